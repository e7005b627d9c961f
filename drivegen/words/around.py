"""What stands before and behind an item of a cover."""

from collections.abc import Sequence

from drivegen.words.cover import Item
from drivegen.words.table import WORD, traffic_names, words
from drivegen.words.things import Fact, Unfit

OTHERS = ("car", "truck", "bus", "vehicle", "member")
"""Vehicles that are not the target."""

TURN_LANES = ("turn_lanes", "turn_lanes_n", "both_turn_lanes")
"""A length right behind them is theirs: "with left and right turn lanes of 60 m"."""


def turn_lanes_before(items: Sequence[Item], i: int) -> bool:
    """Whether what was said last, but for where it is, are turn lanes: "with left-turn lanes on all arms, 50 m long"."""
    said = next((item.phrase for item in reversed(items[:i]) if item.phrase.kind == "fact" or item.text == "."), WORD)
    return said.name in TURN_LANES


def seen_from_target(items: Sequence[Item], i: int) -> None:
    """Raises Unfit where a place is seen from, or something is done to, somebody else: "behind it", "overtaking a bus"."""
    passed = words("determiners") | words("prepositions") | {"of"}
    for item in items[i + 1 :]:
        if item.text in ("it", "them") or item.phrase.name in OTHERS:
            raise Unfit(f"where vehicles are and whom they overtake is said of the target only, not of {item.raw!r}")
        if item.phrase.kind == "thing" or (item.phrase is WORD and item.text not in passed):
            return


def before_noun(items: Sequence[Item], i: int, fact: Fact) -> bool:
    """Whether a noun that can hold the fact, or further words before it, follow at once."""
    for item in items[i + 1 :]:
        if item.text in words("epithets") or item.phrase.kind == "silent":
            continue
        if item.phrase.place == "post" or item.phrase.kind not in ("thing", "fact"):
            return False
        if item.phrase.kind == "thing":
            return item.phrase.name in fact.scope or "*" in fact.scope
    return False


def begins(items: Sequence[Item], i: int) -> bool:
    """Whether a clause begins with the item i: a sentence, or right before a noun, not behind one."""
    before = items[i - 1] if i else None
    if before is None or before.text == "." or before.phrase.kind == "link" or items[i].text == "before":
        return True
    between = words("determiners") | ({","} if items[i].phrase.name == "gap" else set())
    following = next((item.phrase for item in items[i + 1 : i + 4] if item.text not in between), WORD)
    clause = before.phrase is WORD and before.text in (",", "and")
    return clause and following is not WORD and following.place != "post"


def things_follow(items: Sequence[Item], i: int) -> bool:
    """Whether something that roads have is named behind the item i in its sentence."""
    for item in items[i + 1 :]:
        if item.text == ".":
            return False
        if item.phrase.kind == "thing" and item.phrase.name not in traffic_names():
            return True
    return False
