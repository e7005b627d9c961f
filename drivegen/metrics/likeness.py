"""How near one kind of traffic is to another: seven distances, and how far halves of the latter are apart as their unit.

All sides are measured by the same code: motor vehicles on a lane, tracks averaged over SMOOTHING (61 % of the power of NGSIM's
accelerations lies above 1 Hz and is noise). Headways and times to collision are as in `distributions`. Lateral offsets are
from the middle of the nearest lane, less the recording's median, for maps lie beside the lanes that were driven by up to half a
metre. Numbers are compared by the Wasserstein-1 distance, lane changes per kilometre and the share that stands by their
difference. Several sources count equally, however long their recordings are.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from drivegen.core.recorded_log import RecordedLog
from drivegen.core.roadmap import NO_LANE
from drivegen.core.scenario import DT, Actors, Trajectories, VehicleKind
from drivegen.metrics.distributions import LONGEST_HEADWAY, LONGEST_TIME_TO_COLLISION, MOVING, binned, wasserstein
from drivegen.metrics.kinematics import kinematics, within
from drivegen.metrics.surroundings import Boxes, surroundings
from drivegen.roads.graph import LaneGraph
from drivegen.roads.matching import match_route

SMOOTHING = 0.4
"""Standard deviation of the time over which tracks are averaged [s]; steps within twice of it from a track's ends don't count."""

BESIDE = 2.0
"""A vehicle is on a lane within this distance of its middle [m] ..."""

ALONG = np.pi / 4
"""... and this angle to it [rad]."""

STANDING = 0.5
"""A vehicle that is slower stands [m/s]."""

SHORTEST_TRACK = 10.0
"""Lane changes are looked for in tracks that get this far [m]."""

RANGES = {
    "speed": (0.0, 48.0),
    "acceleration": (-6.0, 6.0),
    "headway": (0.0, LONGEST_HEADWAY),
    "lateral_offset": (-BESIDE, BESIDE),
    "time_to_collision": (0.0, LONGEST_TIME_TO_COLLISION),
}
"""Ends of the bins: m/s, m/s2, s, m, s."""

NAMES = (*RANGES, "lane_changes", "standing")
"""The seven, in the order of every array here."""

_MOTOR = (VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Traffic:
    """What vehicles do in some recordings, added up.

    Attributes:
        counts: (5, BINS) in the order of RANGES.
        rates: (2, 2) lane changes and kilometres, standing vehicle steps and all.
    """

    counts: Floats
    rates: Floats

    @classmethod
    def total(cls, parts: "Sequence[Traffic]") -> "Traffic":
        """Of all parts together."""
        return cls(np.sum([part.counts for part in parts], axis=0), np.sum([part.rates for part in parts], axis=0))


def traffic(log: RecordedLog) -> Traffic:
    """What the motor vehicles of a recording do; their boxes must be known."""
    motors = np.isin(log.kind, _MOTOR)
    raw, graph = log.motion[motors], LaneGraph.of(log.map)
    motion = _smoothed(raw)
    on_lane, offset = _offsets(graph, motion)
    speeds, accelerations = within(motion.valid, 1) & on_lane, within(motion.valid, 2) & on_lane
    moves = kinematics(motion)
    boxes = Boxes.of(motion[None], log.size[motors], Actors.none(motion.steps))
    around = surroundings(boxes, len(raw.valid))
    gap, time_to_collision = around.gap[0], around.time_to_collision[0]
    follows = speeds & (moves.speed > MOVING) & np.isfinite(gap)
    headways, times = gap[follows] / moves.speed[follows], time_to_collision[speeds]
    values = (
        moves.speed[speeds],
        moves.acceleration[accelerations],
        headways[headways < LONGEST_HEADWAY],
        (offset - np.median(offset[speeds]))[speeds & (moves.speed > MOVING)],
        times[times < LONGEST_TIME_TO_COLLISION],
    )
    counts = np.stack([binned(v, low, high) for v, (low, high) in zip(values, RANGES.values(), strict=True)])
    standing = (np.count_nonzero(moves.speed[speeds] < STANDING), np.count_nonzero(speeds))
    return Traffic(counts, np.array([_lane_changes(graph, raw, motion), standing], np.float64))


def _smoothed(motion: Trajectories) -> Trajectories:
    reach = round(2 * SMOOTHING / DT)
    position = gaussian_filter1d(motion.position, SMOOTHING / DT, axis=-2, radius=reach)
    whole = minimum_filter1d(motion.valid, 2 * reach + 1, axis=-1, mode="constant")  # nothing averaged over a gap
    return Trajectories(position, motion.heading, motion.velocity, whole)


def _offsets(graph: LaneGraph, motion: Trajectories) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
    """(N, T) whether each vehicle is on a lane, and how far to the left of its middle [m]."""
    on_lane, offset = np.zeros_like(motion.valid), np.zeros(motion.valid.shape, np.float32)
    lane, place = graph.nearest(motion.position[motion.valid], motion.heading[motion.valid], BESIDE, ALONG)
    on_lane[motion.valid], offset[motion.valid] = lane != NO_LANE, place[:, 1]
    return on_lane, offset


def _lane_changes(graph: LaneGraph, raw: Trajectories, motion: Trajectories) -> tuple[int, float]:
    """Lane changes of the tracks that follow a route, and how many kilometres these are long."""
    changes, metres = 0, 0.0
    for track, smooth in ((raw[i], motion[i]) for i in range(len(raw.valid))):
        step = np.diff(smooth.position[smooth.valid], axis=0)
        length = float(np.hypot(*step.T).sum())
        if length < SHORTEST_TRACK:
            continue
        seen = smooth.valid  # changes are looked for on the kilometres that are counted
        route = match_route(graph, track.position[seen], track.heading[seen], beyond=0.0)
        if route is not None:
            changes, metres = changes + route.lane_changes, metres + length
    return changes, metres / 1000


def distances(a: Sequence[Traffic], b: Sequence[Traffic]) -> Floats:
    """(7,) between two sides of one or more sources each, in the order of NAMES; NaN where one side has nothing to compare."""
    sides = [_mixed(side) for side in (a, b)]
    shares = np.stack([shares for shares, _ in sides], axis=1)
    apart = [wasserstein(pair, low, high) for pair, (low, high) in zip(shares, RANGES.values(), strict=True)]
    return np.array([*apart, *np.abs(sides[0][1] - sides[1][1])])


def _mixed(sources: Sequence[Traffic]) -> tuple[Floats, Floats]:
    """Shares (5, BINS) and rates (2,), each source counted equally."""
    with np.errstate(invalid="ignore"):  # a source without a single value has no shares: NaN
        shares = [source.counts / source.counts.sum(axis=1, keepdims=True) for source in sources]
        rates = [source.rates[:, 0] / source.rates[:, 1] for source in sources]
    return np.mean(shares, axis=0), np.mean(rates, axis=0)


def halves_apart(sources: Sequence[Sequence[Traffic]], draws: int, rng: np.random.Generator) -> Floats:
    """(7,) mean distance between random halves of the recordings of each source, which has two or more."""
    drawn = []
    for _ in range(draws):
        shuffled = [[source[i] for i in rng.permutation(len(source))] for source in sources]
        drawn.append(distances(*([Traffic.total(source[half::2]) for source in shuffled] for half in (0, 1))))
    return np.asarray(np.mean(drawn, axis=0))
