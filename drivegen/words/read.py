"""Reads a description of a road and its traffic: one table, one cover, every word.

What cannot be read whole is declined: by the name of what cannot be, with the words that nothing reads, or with both readings
where there are two. The last line of such a message is `try: SENTENCE`, the nearest sentence that would be drawn (`offer.py`).
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeVar

from drivegen.core.errors import UnusableInput
from drivegen.layouts.spec import MapSpec
from drivegen.words.choices import Choices
from drivegen.words.cover import Cover, Grammar, Item
from drivegen.words.request import AT_JUNCTIONS, TrafficRequest
from drivegen.words.roads import specification
from drivegen.words.saying import sentences
from drivegen.words.scene import scene_of
from drivegen.words.table import absent, silent, table, words
from drivegen.words.things import Undrawable, Unfit
from drivegen.words.tokens import Token, stems, tokenise
from drivegen.words.traffic import parted, request, request_sentences

LONGEST = 2000
Meaning = TypeVar("Meaning")
READER = "phrase table (no language model)"
"""Who reads, as it stands in tables."""

SAME = 1e-6
"""Covers whose costs differ by less are equally good."""
_OUTER_LANE = re.compile(r"\bin the (left|right) lane\b(?! (?:next|beside|alongside))")
"""With two lanes this says where somebody is as seen from the target, with more it does not."""
_FOREIGN = stems(
    "und mit eine einer ein der die das zwei drei vier straße kreuzung le la les une avec deux el una con dos de del"
)


@dataclass(frozen=True)
class Words:
    """What a text asks for: a road, None where it speaks of none, and traffic."""

    road: MapSpec | None
    traffic: TrafficRequest

    def sentences(self) -> list[str]:
        """Both as plain sentences, which read the same."""
        return [*(sentences(self.road) if self.road is not None else []), *request_sentences(self.traffic)]


@cache
def grammar(*, traffic: bool = True) -> Grammar:
    """The whole table, or that of roads alone."""
    moving = table("traffic") if traffic else ()
    says_nothing = silent() - words("alike") if traffic else silent()  # "so does the bus": it does what nobody reads
    return Grammar((*table("roads"), *table("lines"), *moving, *table("cannot"), *absent()), says_nothing)


def covers_of(tokens: Sequence[Token]) -> list[Cover]:
    """The best covers of a text, by the table of roads alone where no vehicle and no traffic is named."""
    return grammar(traffic=any(token.text in words("moved") for token in tokens)).covers(tokens)


def key_of(tokens: Sequence[Token]) -> str:
    """What a text's random choices are drawn from: its words, numbers in digits."""
    words = (f"{t.value:g}" if t.value is not None else {"single": "1", "double": "2"}.get(t.text, t.raw) for t in tokens)
    return " ".join(words).replace("1 way", "one way")


def meaning(items: Sequence[Item], choices: Choices) -> Words:
    """What a cover's items mean together. Raises Unfit."""
    road, traffic = parted(scene_of(items))
    lit = any(thing.has("at_light") for thing in traffic.things)
    asked = request(traffic)
    spec = specification(road, choices) if road.things or road.whole.facts or road.links else None
    if lit and (spec is None or '"control":"signals"' not in spec.model_dump_json()):
        raise Unfit("vehicles are said to stand at a traffic light, and no road with traffic lights is described")
    if spec is not None and not _has_junctions(spec) and asked.manoeuvres & AT_JUNCTIONS:
        raise Unfit("vehicles turn or go straight at junctions, and the road that is described has none")
    named = {side for thing in traffic.things for fact in thing.facts for side in _OUTER_LANE.findall(fact.text)}
    if len(named) > 1 or (named and spec is not None and _lanes(spec) > 2):
        raise Unfit(
            f"in which lane the target is nobody says: not 'in the {min(named)} lane' but 'on the {min(named)} of the target'"
        )
    return Words(spec, asked)


def _has_junctions(spec: MapSpec) -> bool:
    """Whether roads meet: ramps and lanes that end are no junctions."""
    return spec.road.kind != "highway" and getattr(spec.road, "junctions", True) != ()


def _lanes(spec: MapSpec) -> int:
    """The lanes of a carriageway, of the widest where roads meet."""
    lanes: list[int] = [getattr(spec.road, "lanes", 0), *(arm.lanes_in for arm in getattr(spec.road, "arms", ()))]
    return max(lanes)


def read(text: str, seed: int, key: str = "") -> Words:
    """The road and the traffic of a text; what it leaves open is drawn from `seed` and `key`, "" for the text itself.

    Raises UnusableInput, reason `not-understood` or `too-long`, whose message says why and ends with what to try instead.
    """
    from drivegen.words.offer import offered  # it reads what it offers

    if len(text) > LONGEST:
        raise UnusableInput(f"the description is longer than {LONGEST} characters", reason="too-long")
    tokens = tokenise(text)
    covers = covers_of(tokens)
    choices = Choices(key or key_of(tokens), seed)
    if (why := unreadable(text, covers[0])) is None:
        words, why = best(covers, choices)
        if words is not None:
            return words
    nearest = offered(tokens, covers, choices)
    left = f" Left out below: {', '.join(map(repr, nearest.left_out))}." if nearest.left_out else ""
    raise UnusableInput(f"{why}.{left}\ntry: {nearest.sentence}", reason="not-understood")


def unreadable(text: str, cover: Cover) -> str | None:
    """Why a cover can mean nothing: words that nothing reads, something that cannot be, or no word at all."""
    unread = list(dict.fromkeys(cover.unread))
    cannot = [(item.phrase.name, item.raw) for item in cover.items if item.phrase.kind == "cannot"]
    named = [f"{name} ({raw!r}) cannot be drawn or simulated" for name, raw in cannot]
    if not cover.items:
        return "the description is empty"
    if unread and (re.search(r"[^\W\d_a-zA-Z]", text) or len(_FOREIGN & set(unread)) > 1):
        return "I read English only: other languages are for a language model (--lm)"
    if unread:
        shown = ", ".join(map(repr, unread[:8])) + (f" and {len(unread) - 8} more" if len(unread) > 8 else "")
        named.append(f"I do not read {shown}")
    return "; ".join(named) or None


def meanings(covers: Sequence[Cover], mean: Callable[[Sequence[Item]], Meaning]) -> tuple[list[Meaning], str]:
    """What the cheapest covers that mean something mean; where none does, why the first one does not."""
    results: list[Meaning] = []
    cost, why = math.inf, ""
    for cover in covers:
        if cover.cost > cost + SAME or cover.unread or any(item.phrase.kind == "cannot" for item in cover.items):
            continue
        try:
            result = mean(cover.items)
        except Unfit as error:
            why = why or str(error)
            cost = min(cost, cover.cost) if isinstance(error, Undrawable) else cost
            continue
        cost = cover.cost
        if result not in results:
            results.append(result)
    return results, why


def best(covers: Sequence[Cover], choices: Choices) -> tuple[Words | None, str]:
    """The meaning of the best cover that has one; None with the reason where none has, or two differ."""
    readings, why = meanings(covers, lambda items: meaning(items, choices))
    if len(readings) > 1:
        first, second = (" ".join(words.sentences()) for words in readings[:2])
        return None, f"this can be read in two ways: {first!r} or {second!r}"
    if readings and readings[0].road is None and not readings[0].traffic:
        return None, "nothing is said of a road or of traffic"
    return (readings[0], "") if readings else (None, why or "no reading makes sense")
