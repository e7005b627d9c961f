"""From a scene to a map specification: which kind of road is spoken of, and its builder. Everything said must end up in it."""

from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from drivegen.layouts.spec import MapSpec
from drivegen.words.build_crossings import crossing
from drivegen.words.build_events import EVENT_FACTS, EVENTS
from drivegen.words.build_grids import grid
from drivegen.words.build_highways import fork, highway
from drivegen.words.build_interchanges import cloverleaf, interchange
from drivegen.words.build_roundabouts import roundabout
from drivegen.words.build_rows import counted
from drivegen.words.build_streets import street
from drivegen.words.choices import Choices, check_lanes
from drivegen.words.things import Fact, Scene, Undrawable, Unfit, merged, only

_BENT = {"line", "arc", "turn", "turn_side", "turn_angle", "turn_to", "bends", "hairpins", "s_turn", "s_arc"}
_SIZES = {"length", "speed", "spacing", "radius", "diameter", "island", "lane_width", "ring_speed"}
_WIDE = ("crossing", "corridor", "grid", "highway", "fork")
_UNNUMBERED = ("street", "main", "side", "cross", "highway", "grid", "fork")
Builder = Callable[[Scene, Choices], dict[str, Any]]


def specification(scene: Scene, choices: Choices) -> MapSpec:
    """The road of a scene. Raises Unfit where none is spoken of, something said fits nowhere, or it cannot be drawn."""
    check_lanes(scene.everything)
    if nothing := next((fact for fact in scene.everything.facts if fact.name in _SIZES and fact.value == 0), None):
        raise Unfit(f"{nothing.text!r} is nothing that could be drawn")
    left_hand = only(scene.everything.values("left_hand"), "traffic is said to keep left and right")
    _directions(scene, bool(left_hand))
    _none_by_number(scene)
    _lights(scene)
    _single_road(scene)
    _cross_streets(scene)
    _country_roads(scene)
    _dead_ends(scene)
    builder = _builder(scene)
    for fact in scene.everything.facts if builder in (crossing, roundabout) else ():
        fact.name = "lanes" if fact.name == "branch_each" else fact.name  # "four arms, each with two lanes"
    fields = builder(scene, choices)
    roads = [thing for thing in scene.things if thing.name in ("street", "highway", "grid", "fork", "crossing")]
    holders = [scene.whole, *(roads if len(roads) == 1 or fields["kind"] == "grid" else ())] if fields["kind"] in _WIDE else []
    if (width := merged(holders).value("lane_width")) is not None:
        fields["lane_width"] = width
    for thing in (scene.whole, *scene.things):
        thing.accept("setting", "arterial")
        if thing.name != "roundabout":
            thing.accept("size")
    if left := scene.unused():
        raise Unfit(f"{left[0]!r} does not fit a road of the kind {fields['kind'].replace('_', ' ')} here")
    try:
        return MapSpec.model_validate({"road": _said(fields), "left_hand": bool(left_hand)})
    except ValidationError as error:
        raise Undrawable(f"this road cannot be drawn: {first_complaint(error)}") from None


def _said(fields: Any) -> Any:
    """Fields without those that are None, which are left to the specification, all the way down."""
    if isinstance(fields, dict):
        return {name: _said(value) for name, value in fields.items() if value is not None}
    return [_said(part) for part in fields] if isinstance(fields, list) else fields


def _directions(scene: Scene, left_hand: bool) -> None:
    """Raises Unfit where a road does not lead as it is said to: what goes through is drawn from west to east."""
    of_map = [fact for fact in scene.everything.facts if fact.name == "side_of_map"]
    east = [fact for fact in scene.everything.facts if fact.name == "gap" and "east" in fact.text.split()]
    if (of_map or east) and scene.everything.has(*_BENT):
        raise Unfit("where a road bends, say how far along it something lies, not in which direction")
    if of_map and left_hand:
        raise Unfit(f"say on which side of the main road it lies, not {of_map[0].text!r}")
    for fact in of_map:
        fact.name = "side"
    for thing in scene.things:
        drawn = "north_south" if thing.name in ("side", "cross") else "east_west"
        if (runs := thing.value("runs")) not in (None, drawn):
            raise Unfit(f"{thing.text!r} is drawn from {drawn.replace('_', ' to ')}, not from {runs.replace('_', ' to ')}")


def _none_by_number(scene: Scene) -> None:
    """Raises Unfit for "the first street": roads have no order, as what lies along a road has."""
    for thing in scene.things:
        if isinstance(thing.which, int) and thing.name in _UNNUMBERED:
            raise Unfit(f"it is not clear which one {thing.text!r} is: say it by main and side road, or by directions")


def _lights(scene: Scene) -> None:
    """Several traffic lights stand at as many crossings along a road: "an arterial with three traffic lights"."""
    for thing in scene.named("lights"):
        if scene.there("crossing", "side", "cross") or not thing.several:
            raise Unfit(f"say at which crossing {thing.text!r} are")
        thing.name = "crossing"
        thing.facts.append(Fact("control", "signals", thing.text, ()))


def _single_road(scene: Scene) -> None:
    """Where nothing splits or joins "a single road" is a road, not that of a fork."""
    forks = scene.there("fork", "left_branch", "right_branch", "branch") or scene.everything.has("splits", "joins", "joins_each")
    for thing in scene.things if not forks else ():
        thing.name = "street" if thing.text == "single road" else thing.name


def _cross_streets(scene: Scene) -> None:
    """Several streets that cross or join one road lie along it: "a boulevard crossed by three streets"."""
    streets = [thing for thing in scene.things if thing.name in ("street", "main") and thing.which is None]
    counts = [next((int(f.value) for f in thing.facts if f.name == "count"), 1) for thing in streets]
    links = scene.links
    crosses = "crosses" in links
    several = len(streets) > 1 and sorted(counts)[-2:-1] == [1] and max(counts) > 1
    if several and (crosses or ("meets" in links and not scene.there("crossing", "roundabout"))):
        streets[counts.index(max(counts))].name = "cross" if crosses else "side"
    for thing in scene.things:
        if thing.name == "cross" and "that" in thing.text and not (thing.several and scene.there("street", "main")):
            thing.name, thing.links = "street", ["crosses"]  # "two streets that cross": one another
        if thing.name == "side" and crosses and thing.several:
            thing.name = "cross"


def _country_roads(scene: Scene) -> None:
    """A highway that is undivided, crossed, or has one lane in each direction in the country, is no motorway."""
    for thing in scene.things:
        if thing.name in ("highway", "street", "main") and thing.value("undivided"):
            thing.name = "street"
    if scene.there("interchange", "cloverleaf", *EVENTS):
        return
    crossed = scene.there("crossing", "roundabout", "side", "cross", "staggered")
    divided = any(thing.name == "highway" and thing.has("divided") for thing in scene.things)
    crossed |= (divided or scene.there("street", "main")) and bool(scene.links & {"crosses", "meets"})
    for thing in scene.things:
        said = {(fact.name, fact.value) for fact in (*thing.facts, *scene.whole.facts)}
        small = {("setting", "rural"), ("lanes_each", 1)} <= said
        ordinary = (crossed and thing.has("divided")) or ("highway" in thing.text and (crossed or small))
        if thing.name == "highway" and ordinary:
            thing.name = "street"
            if "highway" in thing.text and not any(name == "setting" for name, _ in said):
                thing.facts.append(Fact("setting", "rural", thing.text, ()))


def _dead_ends(scene: Scene) -> None:
    """Dead ends beside another road are its side roads: "three cul-de-sacs off a residential street"."""
    beside = scene.there("street", "main")
    for thing in scene.things:
        if thing.name == "dead_end" and beside and (thing.several or thing.has("side") or "meets" in thing.links):
            thing.name = "side"
            thing.facts.append(Fact("dead_end", True, thing.text, ()))


def first_complaint(error: ValidationError) -> str:
    """The first complaint of a specification, without pydantic's words around it."""
    detail = error.errors(include_url=False, include_input=True)[0]
    place = [str(part) for part in detail["loc"] if not isinstance(part, int)][2:]
    message = detail["msg"].removeprefix("Value error, ").replace("Input should be", "must be").replace("Tuple should have", "")
    shown = f" (asked: {detail['input']:g})" if isinstance(detail["input"], int | float) else ""
    return f"{' '.join(place).replace('_', ' ')} {message}{shown}".strip()


def _builder(scene: Scene) -> Builder:
    named: dict[str, Builder] = {"cloverleaf": cloverleaf, "interchange": interchange, "grid": grid}
    if builder := next((builder for name, builder in named.items() if scene.there(name)), None):
        return builder
    facts = {fact.name for fact in scene.everything.facts}
    if any(fact.name == "grid_size" and {"parallel", "rows"} & set(fact.text.split()) for fact in scene.everything.facts):
        return grid
    if (
        scene.there("fork", "left_branch", "right_branch")
        or facts & {"splits", "joins", "splits_each", "joins_each", "branch_lanes"}
    ) and not (scene.there("crossing", "roundabout")):
        return fork
    places = scene.there("crossing", "roundabout", "staggered") or "shape" in facts
    plain = not (scene.there("side", "cross") or _meeting(scene))
    if not places and (scene.there("highway", *EVENTS) or facts & set(EVENT_FACTS) or ("divided" in facts and plain)):
        return highway
    if scene.there("staggered") or _in_a_row(scene):
        return street
    if scene.there("roundabout"):
        return roundabout
    if scene.there("crossing", "east_west", "north_south") or _meeting(scene) or facts & {"arms", "angle"}:
        return crossing
    if scene.there("street", "main", "side", "cross", "dead_end") or facts & _BENT:
        return street
    raise Unfit("no road that I can draw is named")


def _in_a_row(scene: Scene) -> bool:
    """Whether several junctions, or one at a place that is said, lie along one road."""
    junctions = [thing for thing in scene.things if thing.name in ("crossing", "roundabout")]
    news = [thing for thing in junctions if thing.which is None]
    several = len(news) > 1 or any(counted(thing) != 1 for thing in news)
    along = [thing for thing in (*junctions, scene.whole) if thing.has("position", "spacing", "gap", "middle")]
    crossed = any(thing.several for thing in scene.things if thing.name == "cross")
    return crossed or (bool(junctions) and (several or bool(along)))


def _meeting(scene: Scene) -> bool:
    """Whether roads are said to meet or to cross, or there are a main and one side road."""
    if any(thing.name == "dead_end" or thing.has("dead_end") for thing in scene.things):
        return False
    sides = [thing for thing in scene.things if thing.name in ("side", "cross")]
    new = [thing for thing in sides if thing.which is None]
    if len(new) > 1 or any(thing.several for thing in sides) or any(thing.has("position", "side", "middle") for thing in new):
        return False
    return bool(scene.links & {"meets", "crosses"}) or (scene.there("side", "cross") and scene.there("main"))
