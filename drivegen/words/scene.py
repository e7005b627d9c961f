"""A cover as things and what is said of each: which fact belongs to which thing.

A fact before a noun, also one behind its article, belongs to it; one behind belongs to what its clause speaks of, if that
can hold it, else to the nearest thing that can, else to the whole. "on the side road" takes what stands before it in its clause.
Behind a comma, at the end of all things, a fact is of the whole, unless the sentence speaks of one thing ("The side road has").
"""

from collections.abc import Iterable, Sequence
from typing import Any

from drivegen.core.relation import Relation
from drivegen.words.around import OTHERS, TURN_LANES, before_noun, begins, seen_from_target, things_follow, turn_lanes_before
from drivegen.words.cover import Item
from drivegen.words.table import WORD, Phrase, traffic_names, words
from drivegen.words.things import Fact, Scene, Thing, Unfit
from drivegen.words.tokens import stem, stems

ALL = frozenset({"every", "each", "all", "both"})
_KNOWN = stems("the its this that these those")
_NEAREST = _KNOWN - {"the"}
WHOLES = ("crossing", "roundabout", "highway", "street", "grid", "fork", "interchange", "cloverleaf", "staggered", "dead_end")

_BEHIND = ("after", "past", "beyond", "behind")
_PLACES = ("position", "gap", "middle")
_PLACED = ("place", *(f"far_{relation}" for relation in Relation))
_SAID_OF_EACH = ("does", "pace", "at_light", *_PLACED)
"""Behind "a car and a bus" these may be said of both."""
_DONE_TO_TARGET = ("cut_in", "overtake", "turn_left_across")
_LISTED = (",", "and", ".", "")
"""Marks between vehicles that are named one after another; behind others they may be some of those before."""

_RULED_OUT = ("no ", "without ")
_TOGETHER = ("", "grid", "street")
"""What "all" and "each" behind them may be said of: their streets and crossings."""

_DIRECTIONS = {
    "one_way": (*TURN_LANES, "control", "signals", "turn_bans", "speed"),
    "two_way": ("change", "change_to", "loses", "loses_side", "gains", "gains_side"),
}
"""What "in one direction" or "in both" may be said of rather than of its road: "with lights in one direction only"."""

_ROADS = ("street", "main", "east_west", "north_south")
"""Of these alone nobody can be said to stop or to give way: the side road does."""
_SINGLE = (*_ROADS, "side", "cross", "highway", "on_ramp", "off_ramp", "lane_drop", "lane_gain")
_GIVES_WAY = ("stop", "stop_sign", "yield")
_SIDE_ROADS = frozenset({"side", "minor", "priority", "right"})
"""Words of facts that themselves say who gives way: "the main road has priority"."""

MOVING = (*OTHERS, "target")
"""Things of which nothing that roads have is said."""


class Walk:
    """Goes along the items of a cover and builds the scene."""

    def __init__(self, items: Sequence[Item]) -> None:
        self.items = items
        self.scene = Scene()
        self.subject: Thing | None = None
        self.topic: Thing | None = None
        """What the sentence before begins with: "it", where a sentence begins."""
        self.sentence: list[Thing] = []
        self.pending: list[Fact] = []
        self.fronted: list[Fact] = []
        self.segment: list[tuple[Fact, Thing]] = []
        self.mark, self.det, self.comma, self.sticky = ".", "", False, False
        self.shared = False
        """Whether "both with" or "each with" stands behind the subject: it is said of others, too."""
        self.described = False
        """Whether "with" or "has" stands behind the subject: what "and" adds is of it, too."""

    def run(self) -> Scene:
        """The scene. Raises Unfit."""
        for i, item in enumerate(self.items):
            if item.text in words("epithets"):
                continue  # "a two-lane local road" is a two-lane road
            if item.phrase is WORD:
                self._word(item)
            elif item.phrase.kind == "thing":
                self._not_ruled_out(item)
                self._thing(item, item.phrase)
            elif item.phrase.kind == "link":
                self._nothing_pending()
                names = ("meets", "ends") if item.phrase.name == "ends" else (item.phrase.name,)
                (self.subject or self.scene.whole).links.extend(names)
                self.mark, self.comma, self.det = "", False, ""
            elif item.phrase.kind == "fact":
                self._not_ruled_out(item)
                self._fact(i, item, item.phrase)
        self._sentence_ends()
        return self.scene

    def _not_ruled_out(self, item: Item) -> None:
        """Raises Unfit for things behind "and" that "no" or "without" may rule out, too: "without lights and crossings"."""
        before = self.segment[-1][0].text if self.segment else ""
        listed = self.mark == "and" or (self.mark == "" and before.endswith(" and"))
        plain = item.raw.endswith("s") and not item.raw.startswith(_RULED_OUT) and set(item.values) <= {"left", "right"}
        if listed and plain and before.startswith(_RULED_OUT) and not (self.det or self.pending):
            raise Unfit(f"it is not clear whether {before!r} is said of {item.raw!r}, too")

    def _nothing_pending(self) -> None:
        if self.pending:
            raise Unfit(f"it is not clear what {self.pending[0].text!r} belongs to")

    def _word(self, item: Item) -> None:
        word = item.text
        if word not in (",", "and") and word != "":
            self._nothing_pending()
        if word == ".":
            self._sentence_ends()
        elif word in ("(", ":"):
            self.comma, self.sticky, self.mark, self.det = False, self.sticky or word == ":", word, ""
        elif word == ",":
            self.comma, self.segment, self.mark, self.det = True, [], ",", ""
        elif word in words("determiners"):
            if word in ("it", "its") and self.mark == "." and self.topic is not None:
                self.subject, self.sticky = self.topic, True
            self.det = word
        elif word in words("verbs") and self.sticky:
            self.comma = False
        else:
            self.mark = word
            if word in ("with", "has", "having", "where"):
                self.comma, self.described, self.shared = False, True, self.shared or self.det in ALL
            if word not in words("prepositions") and (self.det not in ALL or word in ("with", "has", "having", "where", "and")):
                self.det = ""

    def _sentence_ends(self) -> None:
        self._nothing_pending()
        if self.fronted:
            raise Unfit(f"it is not clear what {self.fronted[0].text!r} belongs to")
        self.topic = self.sentence[0] if self.sentence else None
        self.subject, self.sentence, self.segment = None, [], []
        self.mark, self.det, self.comma, self.sticky = ".", "", False, False

    def _thing(self, item: Item, phrase: Phrase) -> None:
        name = self._kind(item, phrase)
        self.det = "another" if phrase.name == "so_many" else self.det
        slots = zip(phrase.slots, item.values, strict=True)
        facts = [*self.pending, *(Fact(n, v, item.raw, ()) for n, v in (*phrase.facts.items(), *slots))]
        which = [fact.value for fact in facts if fact.name in ("nth", "compass")]
        if which and self.det in ("every", "each"):
            raise Unfit(f"say which ones {self.det} {item.raw!r} is, by their numbers")
        facts = [fact for fact in facts if fact.name not in ("nth", "compass")]
        thing = self._resolved(name, item.raw, which[0] if which else "all" if self.det in ALL else None)
        thing.facts += facts
        self.pending = []
        self._ahead_of_noun(thing)
        if self.subject is not None:
            self._apart(self.subject, thing, item.raw)
        before = (other.phrase for other in reversed(self.items) if other.start < item.start and other.phrase.kind == "fact")
        if phrase.slots == ("lanes_each",) and "lane" not in item.raw and next(before, phrase).name in TURN_LANES:
            raise Unfit(f"it is not clear of what there are so many: {item.raw!r}")
        definite = self.det in _KNOWN or self.det in ALL or bool(which)
        towards = [fact for fact, _ in self.segment if fact.name in ("turn_bans", *TURN_LANES)]
        if self.mark in ("onto", "to") and towards:
            raise Unfit(f"say from which road {towards[0].text!r} is, not into which")
        if item.text == "merge" and self.mark == "and" and self.subject is not None and self.subject.name == "highway":
            raise Unfit(f"{item.raw!r} can be a ramp, or a road that merges")
        if self.mark in words("prepositions") and definite and self.segment:
            for fact, holder in self.segment:
                if fact.value in _GIVES_WAY and thing.name in _ROADS and not _SIDE_ROADS & set(fact.text.split()):
                    raise Unfit(f"say by main and side road where {fact.text!r} is")
                if thing.can_hold(fact):
                    holder.facts.remove(fact)
                    thing.facts.append(fact)
        else:
            self.sticky = definite and self.mark == "."
            thing.beside = self.subject if self.mark == "and" else None
            self.subject = thing
        self.sentence.append(thing)
        self.segment, self.mark, self.det, self.comma, self.described, self.shared = [], "", "", False, False, False

    def _apart(self, subject: Thing, thing: Thing, text: str) -> None:
        """Raises Unfit for a side road of one of several crossings, and for vehicles at what only roads have, or among others."""
        if thing.name == "side" and isinstance(subject.which, int) and subject.name in ("crossing", "roundabout"):
            raise Unfit(f"say 'a side arm on the left' of {subject.text!r}, not {text!r}")
        named = isinstance(subject.which, int) and self.mark in ("", "is") and thing.which is None
        if named and {subject.name, thing.name} <= {"crossing", "roundabout"}:
            raise Unfit(f"say junctions one after the other, not that {subject.text!r} is {text!r}")
        parts = thing.name not in (*WHOLES, "street", *traffic_names()) or thing.which is not None
        if parts and self.mark in words("prepositions") and subject.name in traffic_names():
            raise Unfit(f"where {subject.text!r} is can be said as seen from the target only, not by {text!r}")
        if subject.name == "vehicle" and thing.name in OTHERS[:3] and self.mark not in _LISTED:
            raise Unfit(f"it is not clear whether {text!r} is among {subject.text!r}")
        if self.mark in ("including", "include") and subject.name in OTHERS and thing.name in MOVING:
            raise Unfit(f"it is not clear how many are there beside {text!r}")

    def _kind(self, item: Item, phrase: Phrase) -> str:
        """What a noun names: itself, or of "the second one" and "two on the right" what was counted before."""
        named = [phrase.name]
        on_it = self.mark == "on" and self.det in ("a", "an") and self.subject is not None and self.subject.name == "crossing"
        if phrase.name == "street" and on_it and self.subject and not self.subject.has("count"):
            named = ["main"]  # "a T-junction on a rural road"
        elif phrase.name == "nth_one":
            counted = [t for t in self.scene.things if any(f.name == "count" and f.value != 1 for f in t.facts)]
            named = [t.name for t in counted if t.name not in MOVING]
        elif phrase.name == "so_many":
            named = [t.name for t in self.scene.things[-1:] if t.has("count") and t.has("side")]
        if not named:
            raise Unfit(f"it is not clear what {item.raw!r} is")
        return named[-1]

    def _ahead_of_noun(self, thing: Thing) -> None:
        """Places that stand before their noun are of it: "after 400 m an off-ramp"."""
        again = thing in self.sentence and any(fact.text.endswith("before") for fact in self.fronted)
        if again or any(not thing.can_hold(fact) for fact in self.fronted):
            raise Unfit(f"it is not clear what {self.fronted[0].text!r} belongs to")
        thing.facts += self.fronted
        self.fronted = []

    def _resolved(self, name: str, text: str, which: Any) -> Thing:
        """The thing that is meant: one that was spoken of before, or a new one."""
        like = [thing for thing in self.scene.things if thing.name == name and thing.which == which]
        bare = name in ("main", "side") and not (self.det or self.pending or text.endswith("s"))
        if like and (self.det in _KNOWN or which is not None or bare):
            if name in MOVING and name != "target" and like[-1].text.split()[-1] != text.split()[-1]:
                raise Unfit(f"it is not clear whether {text!r} is among {like[-1].text!r}")
            called = [thing for thing in like if stem(thing.text.split()[-1]) == stem(text.split()[-1])]
            if len(like) > 1 and len(called) != 1 and self.det not in _NEAREST:
                raise Unfit(f"it is not clear which one {text!r} is")
            return called[0] if len(called) == 1 else like[-1]
        if isinstance(which, int) and name in MOVING and self.det == "the":
            raise Unfit(f"it is not clear which one {text!r} is: one of those that are named is 'one of them'")
        self.scene.things.append(Thing(name, text, which=which, definite=self.det in _KNOWN or which is not None))
        return self.scene.things[-1]

    def _fact(self, i: int, item: Item, phrase: Phrase) -> None:
        fact = Fact(phrase.name, item.value, item.raw, phrase.scope)
        before = self.items[i - 1].phrase if i else WORD
        said = next((item.phrase for item in reversed(self.items[:i]) if item.phrase is not WORD), phrase)
        apart = said.kind == "thing" and said.name not in (*fact.scope, "traffic")
        if "direction" in fact.text and fact.name in _DIRECTIONS and (apart or said.name in _DIRECTIONS[fact.name]):
            raise Unfit(f"it is not clear what is {fact.text!r}")
        if fact.name == "length" and before.name in TURN_LANES:
            fact.name, fact.scope = "pocket", before.scope
        elif fact.name == "length" and phrase.place != "pre" and self.comma and turn_lanes_before(self.items, i):
            raise Unfit(f"it is not clear whether {fact.text!r} is said of the turn lanes")
        nothing = self.segment and self.segment[-1][0].name.startswith(("no_", "straight"))  # "no ramps for 2 km"
        placed = bool(self.segment) and self.segment[-1][0].name == "position"
        second = placed and self.mark == "and" and "long" not in fact.text  # "an on-ramp at 500 m and 1500 m"
        if second and fact.name == "length":
            raise Unfit(f"it is not clear what {fact.text!r} belongs to")
        if self.mark in ("at", "for") and fact.name == "length" and not nothing:
            raise Unfit(f"it is not clear what is {self.mark} {fact.text!r}")
        led = bool(self.det) or self.mark in words("prepositions")
        led = led or (phrase.place == "" and (fact.value not in _DONE_TO_TARGET or bool(self.pending)))
        if phrase.place == "pre" or (led and before_noun(self.items, i, fact)):
            self.pending.append(fact)
            self.comma = False
            return
        self._nothing_pending()
        self._check_owner(i, fact)
        self._check_doer(i, fact)
        if fact.name in _PLACED or fact.value in _DONE_TO_TARGET:
            seen_from_target(self.items, i)
        if fact.name == "side" and i + 1 < len(self.items) and self.items[i + 1].phrase.kind == "thing":
            raise Unfit(f"what is said {fact.text!r} {self.items[i + 1].raw!r} cannot be drawn apart")
        if fact.name in _PLACES and begins(self.items, i) and things_follow(self.items, i):
            self.fronted.append(fact)
            return
        holder = self._holder(i, fact)
        self._check_holder(fact, holder)
        holder.facts.append(fact)
        self.segment.append((fact, holder))
        self.mark, self.det = "", ""

    def _check_holder(self, fact: Fact, holder: Thing) -> None:
        """Raises Unfit for what "all" or "each" behind several things, or "and", may say of more than their last one."""
        one = self.subject if self.subject is not None and self.subject.name.endswith("ramp") else holder
        many = one.beside is None and (one.several or stem(one.text) != one.text)
        few = one.name not in _TOGETHER and fact.name not in ("around", "row", "arms") and not many
        roads = bool(self.sentence) and self.sentence[-1].name in MOVING and holder.name not in MOVING
        if self.det in ALL and (few or roads):  # "a car and a truck, both at 50 km/h"
            raise Unfit(f"it is not clear of which {fact.text!r} is said")
        other = holder.beside
        if other is not None and other.name in MOVING and not other.has(*_SAID_OF_EACH) and fact.name in _SAID_OF_EACH:
            raise Unfit(f"it is not clear whether {fact.text!r} is said of {other.text!r}, too")

    def _check_owner(self, i: int, fact: Fact) -> None:
        """Raises Unfit where a fact is said of another one, of the target, or of a road of which it is never so."""
        following = self.items[i + 1].text if i + 1 < len(self.items) else "."
        if fact.text.endswith("before") and following in ("it", "that", "this", ",", "."):
            raise Unfit(f"say what follows after how many metres, not {fact.text + ' ' + following!r}")
        behind = fact.text.split()[-3:]
        if fact.name == "gap" and behind[0] in _BEHIND and behind[1] == "the" and stem(behind[2]) != self._last_noun():
            raise Unfit(f"it is not clear what lies {fact.text!r}")
        only = any(item.phrase.name == "only one of several" for item in self.items[:i])
        if only and {"no", "without", "not"} & set(fact.text.split()):
            raise Unfit(f"say what the others have, not that only one has {fact.text!r}")
        if self.det == "another":
            raise Unfit(f"it is not clear of what other one {fact.text!r} is said")
        if fact.name == "arms" and self.mark in words("prepositions") and not self._all_arms():
            raise Unfit(f"say which ones {fact.text!r} are")  # "a crossing with lights on three arms"
        if fact.name == "spacing" and i and self.items[i - 1].phrase.name == "grid_size" and fact.text.startswith("block"):
            raise Unfit("say the number of crossings and how far apart they are, or the number of blocks alone")
        side_roads = fact.name == "lanes_each" and "side" in fact.text and "lane" not in fact.text  # "two on each side"
        vehicles = fact.name == "branch_lanes" and "lane" not in fact.text and self.scene.there(*MOVING)  # "one left, one right"
        if side_roads or vehicles or (self.mark == "including" and fact.name in TURN_LANES):
            raise Unfit(f"it is not clear of what there are so many: {fact.text!r}")
        if self.det in ("my", "our") and fact.name in ("speed", "pace") and not fact.is_limit:
            raise Unfit("a speed of the target is said so: the target is driving at 50 km/h")
        first = self.subject is not None and self.subject.name in _ROADS[1:] and not self.comma and self.mark != "and"
        if first and fact.value in _GIVES_WAY and not _SIDE_ROADS & set(fact.text.split()):
            raise Unfit(f"say by main and side road where {fact.text!r} is")

    def _check_doer(self, i: int, fact: Fact) -> None:
        """Raises Unfit where the target or another one may do it: "we follow a bus and turn left", "a car, driving straight"."""
        led = any(item.phrase.name == "place" and item.phrase.place == "pre" for item in self.items[:i])
        way = fact.text.startswith("turn") or (i and self.items[i - 1].text == "driving")
        unclear = (led and fact.name in _SAID_OF_EACH) or (way and fact.name in ("straight", "turn_to"))
        if unclear and self.subject and self.subject.name in MOVING and (self.comma or self.mark == "and"):
            raise Unfit(f"it is not clear of whom {fact.text!r} is said")

    def _last_noun(self) -> str:
        """The last word of what was named last."""
        return stem(self.scene.things[-1].text.split()[-1]) if self.scene.things else ""

    def _all_arms(self) -> bool:
        """Whether "on all four arms" says how many there are, and nothing of who gives way on them."""
        return self.det == "all" and not any(fact.value in _GIVES_WAY for fact, _ in self.segment)

    def _holder(self, i: int, fact: Fact) -> Thing:
        subject, whole = self.subject or Thing(""), "" in fact.scope
        one = isinstance(subject.which, int) or subject.name in MOVING
        if one and not (self.comma or subject.can_hold(fact) or fact.is_limit):
            raise Unfit(f"it is not clear what {fact.text!r} belongs to")
        self._not_the_roads(subject, fact)
        if self.shared and subject.name in _SINGLE and not subject.has("count"):
            if not whole or subject.name not in (*_ROADS, "side", "cross"):
                raise Unfit(f"it is not clear of which {fact.text!r} is said")
            return self.scene.whole
        before = self.segment[-1] if self.segment and self.mark == "and" else None
        if whole and before is not None and before[0].name == "control" and before[1] is self.scene.whole:
            return self.scene.whole  # "crossing a four-lane road with signals and turn lanes": of the crossing, both
        holds = [t for t in (self.subject, *reversed(self.sentence)) if t is not None and t.can_hold(fact)]
        of_one = bool(holds) and holds[0].name in WHOLES and sum(thing.name == "street" for thing in self.sentence) < 2
        apart = self.comma or (self.mark == "and" and fact.is_limit and not self.described)
        if apart and not self.sticky and whole and holds and not of_one and not things_follow(self.items, i):
            fact.loose = holds[0].name
            return self.scene.whole
        if holds and (self.subject in holds or not whole):
            return holds[0]
        if whole:
            return self.scene.whole
        earlier = [thing for thing in reversed(self.scene.things) if thing.can_hold(fact) and thing.name not in MOVING]
        if len({thing.name for thing in earlier}) == 1:
            return earlier[0]
        raise Unfit(f"it is not clear what {fact.text!r} belongs to")

    def _not_the_roads(self, ramp: Thing, fact: Fact) -> None:
        """Raises Unfit for what a ramp has, or its road: "motorway on-ramp: 2 lanes", "an exit and two lanes"."""
        new = ramp.name.endswith("ramp") and not ramp.definite and fact.name in ("lanes", "speed") and ramp.can_hold(fact)
        added = self.mark == "and" and not self.described and not fact.is_limit
        alone = ramp.text.startswith(("motorway", "highway", "freeway")) and not self.scene.there("highway", "street", "main")
        if new and (self.sticky or added or alone):
            raise Unfit(f"it is not clear whether {fact.text!r} is said of the ramp or of the road")


def scene_of(items: Iterable[Item]) -> Scene:
    """The scene of a cover's items. Raises Unfit."""
    return Walk(tuple(items)).run()
