"""What a text speaks of: facts, the things that have them, and the whole of them."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

Value = TypeVar("Value")
Road = dict[str, Any]
"""A part of a specification while it is put together, by the names of its fields."""


class Unfit(Exception):
    """What is said cannot be put together; the message says why."""


class Undrawable(Unfit):
    """It can be put together, and cannot be: no costlier reading stands in for it."""


def only(values: Iterable[Value], complaint: str) -> Value | None:
    """The one value that is said, None where none is. Raises Unfit with the complaint where there are several."""
    different = set(values)
    if len(different) > 1:
        raise Unfit(complaint)
    return different.pop() if different else None


@dataclass(eq=False)
class Fact:
    """One thing said; `used` once a specification holds it."""

    name: str
    value: Any
    text: str
    scope: tuple[str, ...]
    used: bool = False
    loose: str = ""

    @property
    def is_limit(self) -> bool:
        """Whether a speed is called a limit, as that of a road is: "a limit of 50 km/h", not "50 km/h"."""
        return self.name == "speed" and "limit" in self.text


@dataclass(eq=False)
class Thing:
    """Something that is spoken of; `which` tells one from its like: an ordinal, a direction [degrees], a side, or all of them."""

    name: str
    text: str = ""
    facts: list[Fact] = field(default_factory=list)
    which: Any = None
    used: bool = False
    definite: bool = False
    links: list[str] = field(default_factory=list)
    beside: "Thing | None" = None
    """What "and" joins it to: "five cars and a truck"."""

    def values(self, name: str) -> list[Any]:
        """All values that are said of a field, in order; they count as used."""
        facts = [fact for fact in self.facts if fact.name == name]
        for fact in facts:
            fact.used = True
        return [fact.value for fact in facts]

    def accept(self, *names: str) -> None:
        """Count these fields as used: what they say holds in what is drawn anyway, or is drawn elsewhere."""
        for name in names:
            self.values(name)

    def value(self, *names: str) -> Any:
        """The only value of all these fields, None where nothing is said. Raises Unfit where two differ."""
        values = [value for name in names for value in self.values(name)]
        if any(value != values[0] for value in values):
            texts = " and ".join(repr(fact.text) for fact in self.facts if fact.name in names)
            raise Unfit(f"{texts} contradict one another")
        return values[0] if values else None

    def among(self, items: list[Any]) -> list[Any]:
        """The one of a list that its ordinal tells, none where there are not so many; all where it has none. 0 is the middle."""
        if not isinstance(self.which, int):
            return items
        if self.which == 0:
            return items[len(items) // 2 :][: len(items) % 2]
        return items[self.which - 1 : self.which] if self.which > 0 else items[-1:]

    def can_hold(self, fact: Fact) -> bool:
        """Whether the fact may be said of it."""
        return self.name in fact.scope or "*" in fact.scope

    @property
    def several(self) -> bool:
        """Whether more than one is asked for."""
        return any(fact.name == "count" and fact.value > 1 for fact in self.facts)

    def has(self, *names: str) -> bool:
        """Whether any of these fields is spoken of; they do not count as used."""
        return any(fact.name in names for fact in self.facts)


def merged(things: Iterable[Thing]) -> Thing:
    """What is said of several things, as one."""
    return Thing("", facts=[fact for thing in things for fact in thing.facts])


@dataclass
class Scene:
    """Everything that is said: things in order, and the whole."""

    things: list[Thing] = field(default_factory=list)
    whole: Thing = field(default_factory=lambda: Thing(""))

    def named(self, *names: str) -> list[Thing]:
        """The things of these names; they count as used."""
        things = [thing for thing in self.things if thing.name in names]
        for thing in things:
            thing.used = True
        return things

    def there(self, *names: str) -> bool:
        """Whether any thing of these names is spoken of."""
        return any(thing.name in names for thing in self.things)

    def merged(self, *names: str) -> Thing:
        """What is said of the whole and of things of these names that no ordinal or direction tells apart, as one thing."""
        return replace(merged((self.whole, *self.named(*names))), name=" ".join(names))

    def one_road(self, *names: str) -> None:
        """Raises Unfit where more than one thing of these names is spoken of."""
        things = [thing for thing in self.things if thing.name in names and thing.which is None]
        if len(things) > 1:
            raise Unfit(f"it is not clear how {' and '.join(repr(thing.text) for thing in things[:3])} belong together")

    @property
    def everything(self) -> Thing:
        """What is said of the whole and of all things, as one."""
        return merged((self.whole, *self.things))

    @property
    def links(self) -> set[str]:
        """How things are related."""
        return {link for thing in (self.whole, *self.things) for link in thing.links}

    def unused(self) -> list[str]:
        """What no specification holds, as it was said."""
        facts = [fact.text for fact in self.everything.facts if not fact.used]
        return [*facts, *(thing.text for thing in self.things if not thing.used)]
