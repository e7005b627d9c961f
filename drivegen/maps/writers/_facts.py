"""What a description says about a road, before it is one road: plain facts, each found by its own small rule."""

from dataclasses import dataclass, field

from drivegen.maps.spec_values import Control, Side


@dataclass
class JunctionWords:
    """A junction that is mentioned.

    Attributes:
        form: "crossing" or "roundabout". at: place in the text. arms: roads that meet, None unsaid. shape: "t", "y" or "".
        count: how many of them. control: its own, as `Facts.control`, or "unsignalled". side: of its side road.
        gap: from the junction before it [m]. position: from the start of the road [m]. pockets: sides of its own turn lanes.
        middle: it lies in the middle of the road.
    """

    form: str
    at: int
    arms: int | None = None
    shape: str = ""
    count: int = 1
    control: str | None = None
    side: Side | None = None
    gap: float | None = None
    position: float | None = None
    pockets: str = ""
    middle: bool = False


@dataclass
class EventWords:
    """A ramp or a change of lanes along a highway, in the order of the text; lengths [m], speed [m/s], None unsaid.

    Attributes:
        keeps: as in `spec.HighwayEvent`.
        position: from the start of the road. gap: from what comes before it. length: of the lane beside the road.
    """

    kind: str
    at: int
    lanes: int | None = None
    side: Side = "right"
    position: float | None = None
    gap: float | None = None
    length: float | None = None
    speed: float | None = None
    keeps: bool = False


@dataclass
class Facts:
    """Facts of one description; None is unsaid.

    Attributes:
        features: words that decide the kind ("highway", "grid", "curve", ...) and where in the text they stand.
        lanes: per direction by role: "main", "side", "ring", "ramp", "arms", "back" (of the main road);
            `other_lanes` are those without one, in order.
        from_lanes, to_lanes: of a road that narrows or widens. branches: lanes of the left and right branch of a fork.
        steps: in how many steps it does so, step_places: where they lie [m]. whole: the length said is that of the whole road.
        speeds: [m/s] by role "main", "side", "ramp", "ring", "loop". lengths: [m] by role "length", "spacing", "radius",
            "diameter", "auxiliary", "offset", "position", "side", "median", "island" (in the middle of a ring), "pocket" (of
            turn lanes), "straights" (beside bends), "before" and "behind" (the one
            bend), "branch" and "stem" (of a fork), "rest" (of the road, behind its last change), "beyond" (streets of a
            grid, past its crossings), "from_bend" (to the first junction). angle: [degrees]. bends: how many, None unsaid.
            arcs: turn [degrees], positive to the left, and radius [m] of bends that differ.
        at_bend: where junctions lie against bends, "in", "before" or "behind" them, "" no bends. side_turn: side of side roads
            along a bend, "inside" its inner one; side_turns: where in the text it is said.
        one_way: places in the text of roads that are said to be one-way; one_way_role: of the only one of two roads that is.
        two_way: a road is said to run both ways.
        side_places: side ("left", "right" or "") and position along the road [m] of side streets told one by one.
        pocket_role: of the road that has the turn lanes, "" all. interchange: its form, "" none;
            loops: how many loop ramps it has.
    """

    features: dict[str, int] = field(default_factory=dict)
    junctions: list[JunctionWords] = field(default_factory=list)
    events: list[EventWords] = field(default_factory=list)
    grid: tuple[int, int] | None = None
    side_streets: int = 0
    side_places: list[tuple[str, float | None]] = field(default_factory=list)
    lanes: dict[str, int] = field(default_factory=dict)
    other_lanes: list[tuple[int, int]] = field(default_factory=list)
    from_lanes: int | None = None
    to_lanes: int | None = None
    branches: tuple[int, int] | None = None
    steps: int = 1
    step_places: list[float] = field(default_factory=list)
    whole: bool = False
    speeds: dict[str, float] = field(default_factory=dict)
    lengths: dict[str, float] = field(default_factory=dict)
    angle: float | None = None
    turn: Side | None = None
    bends: int | None = None
    at_bend: str = ""
    side_turn: str = ""
    side_turns: set[int] = field(default_factory=set)
    arcs: list[tuple[float, float | None]] = field(default_factory=list)
    control: Control | None = None
    unsignalled: bool = False
    one_way: list[int] = field(default_factory=list)
    one_way_role: str = ""
    two_way: bool = False
    left_hand: bool = False
    left_pocket: bool = False
    right_pocket: bool = False
    pocket_role: str = ""
    surroundings: str = ""
    interchange: str = ""
    loops: int | None = None

    def has(self, *features: str) -> bool:
        """Whether any of the features is there."""
        return any(feature in self.features for feature in features)
