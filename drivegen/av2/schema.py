"""Words of the Argoverse 2 Motion Forecasting format, as the av2 package's own schema has them, and ours beside them.

Source: argoverse/av2-api, `datasets/motion_forecasting/data_schema.py`, `map/lane_segment.py`.
"""

from enum import IntEnum

import pyarrow as pa

from drivegen.core.scenario import VehicleKind

OBSERVED_STEPS = 50
"""Steps that the official challenge shows to a predictor; the flag `observed` marks them."""

SIZE_COLUMNS = ("length", "width", "height")
"""Our columns beside the official ones [m]; NaN where unknown."""

TRUCK = "truck"
"""Another of ours: whether a `vehicle` is a truck, for which the format has no word."""

COLUMNS = pa.schema(
    [
        ("observed", pa.bool_()),
        ("track_id", pa.string()),
        ("object_type", pa.string()),
        ("object_category", pa.int64()),
        ("timestep", pa.int64()),
        ("position_x", pa.float64()),
        ("position_y", pa.float64()),
        ("heading", pa.float64()),
        ("velocity_x", pa.float64()),
        ("velocity_y", pa.float64()),
        ("scenario_id", pa.string()),
        ("start_timestamp", pa.float64()),
        ("end_timestamp", pa.float64()),
        ("num_timestamps", pa.int64()),
        ("focal_track_id", pa.string()),
        ("city", pa.string()),
        *((name, pa.float64()) for name in SIZE_COLUMNS),
        (TRUCK, pa.bool_()),
    ]
)
"""The 16 official columns, then ours."""

WORDS = ("track_id", "object_type")
"""Columns that are read as dictionaries: few different values, many rows."""

CONSTANTS = ("scenario_id", "focal_track_id", "city")
"""Columns with one value in the whole file."""

NUMBERS = ("position_x", "position_y", "heading", "velocity_x", "velocity_y")

REQUIRED = ("timestep", *WORDS, *NUMBERS, *CONSTANTS)
"""Columns without which a file cannot be used."""

READ, REPEATED = [*REQUIRED, *SIZE_COLUMNS, TRUCK], [*WORDS, *CONSTANTS]
"""Columns that are read, ours where they are there; and those of them with few different values."""

EGO_TRACK = "AV"
"""Track id of the recording vehicle."""


class TrackCategory(IntEnum):
    """How good a track is and whether the challenge scores it."""

    FRAGMENT = 0
    UNSCORED = 1
    SCORED = 2
    FOCAL = 3


KIND_OF_TYPE = {
    "vehicle": VehicleKind.CAR,
    "bus": VehicleKind.BUS,
    "pedestrian": VehicleKind.PEDESTRIAN,
    "cyclist": VehicleKind.CYCLIST,
    "riderless_bicycle": VehicleKind.CYCLIST,
    "motorcyclist": VehicleKind.MOTORCYCLE,
}
"""Object types that move or get in the way; all others (static, background, construction, unknown) are skipped."""

TYPE_OF_KIND = {
    VehicleKind.CAR: "vehicle",
    VehicleKind.TRUCK: "vehicle",  # the column TRUCK tells
    VehicleKind.BUS: "bus",
    VehicleKind.PEDESTRIAN: "pedestrian",
    VehicleKind.CYCLIST: "cyclist",
    VehicleKind.MOTORCYCLE: "motorcyclist",
}

TRUCK_LENGTH = 6.5
"""A `vehicle` whose own box is longer [m] is read as a truck where no column TRUCK tells."""

CROSSABLE_MARKS = frozenset(
    {
        "NONE",
        "UNKNOWN",
        "DASHED_WHITE",
        "DASHED_YELLOW",
        "DOUBLE_DASH_WHITE",
        "DOUBLE_DASH_YELLOW",
        "DASH_SOLID_WHITE",
        "DASH_SOLID_YELLOW",
    }
)
"""Lane marks that may be crossed from their lane; of a double line the first word is the side of that lane
(as av2's `rendering/map.py` draws it). All others are solid on that side."""
