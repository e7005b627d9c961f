"""Who goes first at a junction, as the description says it for all junctions or for this one."""

from typing import get_args

from drivegen.maps.spec_values import Control
from drivegen.maps.writers._facts import Facts, JunctionWords
from drivegen.maps.writers._phrases import Phrase


def control_of(facts: Facts, equal_roads: bool) -> str:
    """The control of all junctions; a stop sign where no road is the main one is for everybody."""
    if facts.control == "stop" and equal_roads:
        return "all_way_stop"
    return facts.control or "yield"


def control_at(facts: Facts, words: JunctionWords, equal_roads: bool) -> str:
    """The control of a junction that may itself be called signalised or unsignalised."""
    if words.control == "unsignalled":
        rest = control_of(facts, equal_roads)
        return "yield" if rest == "signals" else rest
    if words.control:
        return "all_way_stop" if words.control == "stop" and equal_roads else words.control
    return control_of(facts, equal_roads)


def one_for_all(phrase: Phrase) -> Control | None:
    """The control that the words of a staggered junction, or of its halves, ask for."""
    return next((name for name in get_args(Control) if name == phrase.words.get("control")), None)
