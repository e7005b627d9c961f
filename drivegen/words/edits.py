"""Edits of a specification in words: the same table and rules, each fact set where its scope says."""

from contextlib import suppress
from functools import cache

from pydantic import ValidationError

from drivegen.core.errors import UnusableInput
from drivegen.layouts.spec import MapSpec
from drivegen.words.build_events import EVENTS
from drivegen.words.cover import Grammar
from drivegen.words.edit_fields import Edit
from drivegen.words.read import meanings, unreadable
from drivegen.words.roads import first_complaint
from drivegen.words.scene import scene_of
from drivegen.words.table import silent, table, words
from drivegen.words.things import Scene, Undrawable, Unfit
from drivegen.words.tokens import tokenise

EDITS = (
    "30 km/h on the side road",
    "add a lane in each direction",
    "remove the traffic lights",
    "make it a roundabout",
    "add an on-ramp",
    "add an off-ramp",
    "remove the off-ramp",
    "the on-ramp 100 m downstream",
    "200 m longer",
    "left-turn lanes on the main road",
    "traffic on the left",
    "two lanes in each direction",
    "replace the traffic lights by stop signs",
    "lanes 3.5 m wide",
    "the right lane ends after 600 m",
)
"""One edit of each kind; all of them are read."""


@cache
def _grammar() -> Grammar:
    return Grammar((*table("edits"), *table("roads"), *table("lines"), *table("cannot")), silent() | words("edits"))


def edited(spec: MapSpec, text: str) -> MapSpec:
    """The specification after the edit. Raises UnusableInput, its last line being `try: EDIT`, one that this road can have."""
    covers = _grammar().covers(tokenise(text[:2000]))
    if why := unreadable(text, covers[0]):
        raise _declined(spec, text, why)
    results, why = meanings(covers, lambda items: apply(spec, scene_of(items)))
    if len(results) != 1:
        raise _declined(spec, text, "this can be read in two ways" if results else why)
    return results[0]


def _declined(spec: MapSpec, text: str, why: str) -> UnusableInput:
    words_of_it = set(text.lower().split())
    for edit in (*sorted(EDITS, key=lambda edit: -len(words_of_it & set(edit.split()))), "50 km/h"):
        with suppress(Unfit):
            apply(spec, scene_of(_grammar().covers(tokenise(edit))[0].items))
            break
    return UnusableInput(f"{why}\ntry: {edit}", reason="not-understood")


def apply(spec: MapSpec, scene: Scene) -> MapSpec:
    """The specification with the scene's facts in it. Raises Unfit where one fits nowhere, or nothing changes."""
    if spec.road.kind == "graph":
        raise Unfit("a free graph cannot be edited in words")
    fields = spec.model_dump(mode="json")
    _check_clear(spec, scene)
    for thing in (scene.whole, *scene.things):
        if (left_hand := thing.value("left_hand")) is not None:
            fields["left_hand"] = left_hand
        Edit(fields, thing).run()
    if left := [fact for fact in scene.everything.facts if not fact.used]:
        if left[0].name == "remove":
            raise Unfit("ramps, changes of lanes, lights, signs, turn lanes and bends can be removed, nothing else")
        raise Unfit(f"{left[0].text!r} cannot be set on this {spec.road.kind.replace('_', ' ')}")
    try:
        after = MapSpec.model_validate(fields)
    except ValidationError as error:
        raise Undrawable(f"after this edit the road cannot be drawn: {first_complaint(error)}") from None
    if after == spec:
        raise Unfit("this changes nothing")
    _check_bends(spec, after)
    return after


def _check_clear(spec: MapSpec, scene: Scene) -> None:
    """Raises Unfit where things are named of which nothing is said, or lanes of which it is open whose they are."""
    itself = {"corridor": ("street",), "highway": ("highway", "street"), "roundabout": ()}.get(spec.road.kind, (spec.road.kind,))
    for thing in scene.things:
        new = thing.name in EVENTS and not (thing.definite or scene.whole.has("more_lanes"))
        if not (thing.facts or new or (thing.name in itself and thing.which is None)):
            raise Unfit(f"it is not clear what changes at {thing.text!r}: say it as in 'add a lane on the side road'")
    if any(fact.name == "keeps" and fact.text.startswith("add ") for fact in scene.everything.facts):
        raise Unfit("say how many lanes the ramp has, as in 'two lanes on the off-ramp'")
    lanes = [fact.text for fact in scene.whole.facts if fact.name.startswith("lane") and fact.name != "lane_width"]
    if lanes and any(thing.name in ("lane_drop", "lane_gain") for thing in scene.things):
        raise Undrawable(f"it is not clear whether {lanes[0]!r} is of the road: say it in an edit of its own")


def _check_bends(before: MapSpec, after: MapSpec) -> None:
    """Raises Undrawable where bends that fitted into their road do not fit any more."""
    was, line = (getattr(spec.road, "alignment", None) for spec in (before, after))
    if line is not None and line.too_short and not (was is not None and was.too_short):
        raise Undrawable(f"after this edit its bends do not fit into a road of {line.length:.0f} m")
