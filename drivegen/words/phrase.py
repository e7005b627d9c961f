"""What a phrase is: a thing, a fact about things, a link between things, something that cannot be, or nothing at all."""

from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["thing", "fact", "link", "cannot", "silent", "word"]


@dataclass(frozen=True, eq=False)
class Phrase:
    """One entry of the table: what it means, and the forms in which it is said, the first of which is spoken.

    Attributes:
        kind: see above. name: of the thing, or the field that the fact is about.
        forms: see `forms.py`. value: of a fact without slots; with slots their value, or their values.
        scope: names of the things that can hold the fact; "" is the whole.
        facts: what a thing's own name says of it. slots: fields that the slots of a thing's forms fill.
        place: "pre": only before the noun that it belongs to ("two-lane"); "post": never there; "": either.
    """

    kind: Kind
    name: str
    forms: tuple[str, ...]
    value: Any = None
    scope: tuple[str, ...] = ()
    facts: dict[str, Any] = field(default_factory=dict)
    slots: tuple[str, ...] = ()
    place: Literal["", "pre", "post"] = ""


WORD = Phrase("word", "", ())
"""Stands for a word or mark that no phrase holds."""
