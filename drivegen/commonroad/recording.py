"""A whole CommonRoad file as one recording: map, tracks and signals at 10 Hz.

Format: "CommonRoad: Documentation of the XML Format", versions 2018b and 2020a, Technical University of Munich. Planning
problems are left out: their vehicle has no box and no trajectory.
"""

from drivegen.commonroad.lanelets import read_map
from drivegen.commonroad.obstacles import read_tracks
from drivegen.commonroad.values import number, refuse
from drivegen.core.recorded_log import NO_TRACK, RecordedLog
from drivegen.core.safe_xml import parse
from drivegen.core.scenario import DT
from drivegen.core.signals import Signals

VERSIONS = ("2018b", "2020a")

MOST_IN_A_STEP = 1000
"""So many of a file's time steps make 0.1 s at most."""


def read_recording(raw: bytes, place: str, source: str) -> RecordedLog:
    """The recording in a file's bytes, without focal track; `place` names the file in errors.

    Time steps that divide 0.1 s are thinned out to 0.1 s. Raises UnusableInput, with a reason, for all other time steps,
    other versions, and whatever is no sound file.
    """
    root = parse(raw, place, root="commonRoad")
    version = root.get("commonRoadVersion", "")
    if version not in VERSIONS:
        refuse(f"{place} has version {version!r}; known are {' and '.join(VERSIONS)}", "unknown-version")
    stride = _stride(root.get("timeStepSize"), place)
    road_map, lights = read_map(root, place)
    tracks = read_tracks(root, road_map.origin, stride, place)
    name = root.get("benchmarkID", "").strip()
    return RecordedLog(
        scenario_id=name,
        source=source,
        city=_city(name),
        map=road_map,
        track_id=tracks.track_id,
        kind=tracks.kind,
        size=tracks.size,
        motion=tracks.motion,
        focal=NO_TRACK,
        ego=NO_TRACK,
        signals=Signals(lights.lane, lights.shown(tracks.motion.steps, stride)),
        skipped=tracks.skipped,
    )


def _stride(text: str | None, place: str) -> int:
    """How many of the file's time steps make 0.1 s."""
    size = number(text, "timeStepSize", place)
    stride = round(DT / size) if size >= DT / MOST_IN_A_STEP else 0
    if stride < 1 or abs(stride * size - DT) > 1e-6:
        refuse(f"{place} has time steps of {size:g} s, which do not make up {DT:g} s", "time-step")
    return stride


def _city(benchmark: str) -> str:
    """The map's name in a benchmark id, which is [C-]<country>_<map>-<number>_<recording>_<kind>-<number>."""
    parts = benchmark.split("_")
    return parts[1].rpartition("-")[0] or parts[1] if len(parts) > 1 else benchmark
