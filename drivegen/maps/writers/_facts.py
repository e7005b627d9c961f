"""What a description says about a road, before it is one road: plain facts, each found by its own small rule."""

from dataclasses import dataclass, field

from drivegen.maps.spec import Control, Side


@dataclass(frozen=True)
class JunctionWords:
    """A junction that is mentioned: its form, how many roads meet (None unsaid), T or Y shape, how many there are."""

    form: str
    at: int
    arms: int | None = None
    shape: str = ""
    count: int = 1
    signals: bool | None = None


@dataclass(frozen=True)
class EventWords:
    """A ramp or a change of lanes along a highway, in the order of the text."""

    kind: str
    at: int
    lanes: int | None = None
    side: Side = "right"


@dataclass
class Facts:
    """Facts of one description; None is unsaid.

    Attributes:
        features: words that decide the kind ("highway", "grid", "curve", ...) and where in the text they stand.
        lanes: per direction by role: "main", "side", "ring", "ramp"; `other_lanes` are those without one, in order.
        from_lanes, to_lanes: of a road that narrows or widens.
        speeds: [m/s] by role "main", "side", "ramp", "ring". lengths: [m] by role "length", "spacing", "radius",
            "diameter", "auxiliary", "offset", "position", "side". angle: [degrees].
        one_way: how many roads are said to be one-way. two_way: a road is said to run both ways.
    """

    features: dict[str, int] = field(default_factory=dict)
    junctions: list[JunctionWords] = field(default_factory=list)
    events: list[EventWords] = field(default_factory=list)
    grid: tuple[int, int] | None = None
    side_streets: int = 0
    lanes: dict[str, int] = field(default_factory=dict)
    other_lanes: list[tuple[int, int]] = field(default_factory=list)
    from_lanes: int | None = None
    to_lanes: int | None = None
    speeds: dict[str, float] = field(default_factory=dict)
    lengths: dict[str, float] = field(default_factory=dict)
    angle: float | None = None
    turn: Side | None = None
    control: Control | None = None
    unsignalled: bool = False
    one_way: list[int] = field(default_factory=list)
    two_way: bool = False
    left_hand: bool = False
    left_pocket: bool = False
    right_pocket: bool = False
    surroundings: str = ""

    def has(self, *features: str) -> bool:
        """Whether any of the features is there."""
        return any(feature in self.features for feature in features)
