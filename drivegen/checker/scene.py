"""The entrance to the legal checker: one `SceneChecker` per scenario, asked for one vehicle or for whole samples.

What the arrays mean: `violation` are `samples.Violation` flags, 0 is legal; `first` is the first step at which the
trajectory is illegal, -1 if it is legal. A trajectory with a number that is not finite at a valid step is illegal, and
that step is nobody's obstacle. A pair of boxes that overlaps at its first common step is not judged until it has come
apart, and who starts off the road is judged once it is on it: initial states are given.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drivegen.checker import collisions, dynamics, priority, road
from drivegen.checker.limits import FLAGS, NEVER, NOT_FINITE, OVERLAP, OVERLAP_CONTEXT, RULES, YIELD_GAP, Limits
from drivegen.core.boxes import bounds
from drivegen.core.geometry import unit
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.roads.drivable import RoadField, road_field
from drivegen.roads.gates import Gates

NOBODY = -1

_FLAGS = np.array(FLAGS, np.uint16)


@dataclass(frozen=True)
class Severities:
    """How far trajectories went, rule by rule; leading dimensions are those that were asked for.

    Attributes:
        worst: (..., R) float32 largest severity in the order of `limits.RULES`, -inf where a rule had nothing to judge.
        first: (..., R) int16 first step beyond the limit, -1 if never.
    """

    worst: NDArray[np.float32]
    first: NDArray[np.int16]

    @property
    def violation(self) -> NDArray[np.uint16]:
        """(...) Violation flags."""
        flags: NDArray[np.uint16] = np.bitwise_or.reduce(np.where(self.first >= 0, _FLAGS, np.uint16(0)), axis=-1)
        return flags

    @property
    def first_step(self) -> NDArray[np.int16]:
        """(...) first step at which any rule is broken, -1 if none is."""
        steps = np.where(self.first >= 0, self.first, np.iinfo(np.int16).max).min(axis=-1)
        return np.where(steps == np.iinfo(np.int16).max, -1, steps).astype(np.int16)

    def __getitem__(self, index: Any) -> "Severities":
        """The chosen trajectories, as in `severities[low:high]`."""
        return Severities(self.worst[index], self.first[index])


ROOM = 20.0
"""Rasters are made so much [m] farther out than motion has yet been judged: the next motion is most likely near the last."""


class SceneChecker:
    """The legal checker of one scenario; what takes longest are the rasters of the road, made where motion is judged.

    Args:
        scenario: its map, sizes, context actors and signals are read; its log is not.
        limits: Limits.
    """

    def __init__(self, scenario: Scenario, limits: Limits) -> None:
        self.size = np.ascontiguousarray(scenario.vehicles.size[:, :2], np.float32)
        self.limit = limits.severities().astype(np.float32)
        self._map = scenario.map
        self._field: RoadField | None = None
        self._looked_at = np.full(2, np.inf), np.full(2, -np.inf)  # least and most [m]: nowhere
        self._context = _arrays(scenario.context.motion)
        self._context_size = np.ascontiguousarray(scenario.context.size[:, :2], np.float32)
        gates = Gates.of(scenario.map, scenario.signals)
        self._gates = (
            gates.position, gates.direction, gates.group, gates.start, gates.end, gates.line, gates.red_for, gates.stop,
            gates.give_way, gates.conflict_start, gates.conflict, gates.conflict_direction,
        )  # fmt: skip

    def check(
        self, vehicle: int, motion: Trajectories, committed: Trajectories, committed_size: NDArray[np.float32]
    ) -> tuple[NDArray[np.uint16], NDArray[np.int16]]:
        """Judge K candidates of one vehicle against what is committed already; leave out of it whom to ignore.

        Args:
            vehicle: index into the scenario's vehicles.
            motion: (K, T) its candidates. committed: (M, T) others' motion. committed_size: (M, 2) length, width [m].

        Returns violation (K,) and first (K,).
        """
        severities = self.severities_of(vehicle, motion, committed, committed_size)
        return severities.violation, severities.first_step

    def partners(self, vehicle: int, motion: Trajectories, committed: Trajectories) -> NDArray[np.bool_]:
        """Which of the scenario's N committed vehicles (N, T) collide with one trajectory (T,) of `vehicle`: (N,)."""
        position, heading, _, valid = _arrays(committed)
        other_position, other_heading, _, other_valid = _arrays(motion[np.newaxis])
        worst, first = _nothing(len(self.size))
        mine = (other_position, other_heading, other_valid, self.size[vehicle : vehicle + 1])
        collisions.against(position, heading, valid, self.size, *mine, self.limit[OVERLAP], worst, first)
        return np.not_equal(first, -1)

    def severities_of(
        self, vehicle: int, motion: Trajectories, committed: Trajectories, committed_size: NDArray[np.float32]
    ) -> Severities:
        """As `check`, with every rule's severity."""
        alone = self.alone(np.full(len(motion.valid), vehicle), motion)
        return self.among_committed(vehicle, motion, committed, committed_size, alone)

    def alone(self, vehicle: NDArray[np.integer], motion: Trajectories) -> Severities:
        """Rules that need no other vehicle, for B trajectories (B, T) of the vehicles (B,); a start for `among_committed`."""
        return self._judge_alone(_arrays(motion), motion.valid, self.size[vehicle])

    def among_committed(
        self,
        vehicle: int,
        motion: Trajectories,
        committed: Trajectories,
        committed_size: NDArray[np.float32],
        alone: Severities,
    ) -> Severities:
        """`alone` for the K candidates (K, T) of one vehicle, completed in place by the rules that need others."""
        sample = np.zeros(len(motion.valid), np.int64)
        return self.among_samples(vehicle, motion, sample, committed[np.newaxis], committed_size, alone)

    def among_samples(
        self,
        vehicle: int,
        motion: Trajectories,
        sample: NDArray[np.int64],
        committed: Trajectories,
        committed_size: NDArray[np.float32],
        alone: Severities,
    ) -> Severities:
        """As `among_committed`, each of B candidates (B, T) in its own one of samples (K, M, T); `sample` (B,) is sorted."""
        size = np.repeat(self.size[vehicle : vehicle + 1], len(sample), axis=0)
        other_size = np.ascontiguousarray(committed_size[:, :2], np.float32)
        arrays, others = _arrays(motion), _arrays(committed)
        _among_samples(self._gates, arrays, size, sample, others, other_size, self.limit, alone.worst, alone.first)
        return alone

    def check_samples(self, motion: Trajectories, ignore_target: bool = False) -> tuple[NDArray[np.uint16], NDArray[np.int16]]:
        """Judge K samples of all N vehicles at once; both partners of a collision are charged.

        Args:
            motion: (K, N, T). ignore_target: leave the target out of collisions, and as one to give way to, because its driver
                has yet to react; the target itself is still judged by all other rules, giving way among them.

        Returns violation (K, N) and first (K, N).
        """
        severities = self.severities(motion, ignore_target)
        return severities.violation, severities.first_step

    def takes_way(self, motion: Trajectories, ignore_target: bool = False) -> NDArray[np.bool_]:
        """Who of K samples (K, N, T) does not give way, as `check_samples` has it: (K, N)."""
        arrays = _arrays(motion)
        worst, first = _nothing(*arrays[3].shape[:2], len(RULES))
        priority.judge_samples(self._gates, *arrays, self.size, TARGET if ignore_target else NOBODY, self.limit, worst, first)
        return np.asarray(first[..., YIELD_GAP] >= 0)

    def severities(self, motion: Trajectories, ignore_target: bool = False) -> Severities:
        """As `check_samples`, with every rule's severity: `worst` and `first` are (K, N, R)."""
        position, heading, _, valid = arrays = _arrays(motion)
        samples, count, _ = valid.shape
        skip = TARGET if ignore_target else NOBODY
        flat = self._judge_alone(_flat(arrays), motion.valid.reshape(-1, motion.steps), np.tile(self.size, (samples, 1)))
        severities = Severities(flat.worst.reshape(samples, count, -1), flat.first.reshape(samples, count, -1))
        worst, first = _nothing(samples, count)
        collisions.among(position, heading, valid, self.size, skip, self.limit[OVERLAP], worst, first)
        severities.worst[..., OVERLAP], severities.first[..., OVERLAP] = worst, first
        priority.judge_samples(self._gates, *arrays, self.size, skip, self.limit, severities.worst, severities.first)
        return severities

    def _judge_alone(self, arrays: "_Arrays", stated: NDArray[np.bool_], size: NDArray[np.float32]) -> Severities:
        """All rules that need no other vehicle, for B trajectories; context actors are part of the scenario.

        `stated` (B, T) are the steps that the trajectories call valid, whether their numbers are finite or not.
        """
        position, heading, velocity, valid = arrays
        direction = unit(np.where(valid, heading, np.float32(0)))
        worst, first = _nothing(len(size), len(RULES))
        dynamics.judge(position, direction, velocity, valid, self.limit, worst, first)
        field = self._field_around(position, valid, size)
        rasters = (field.outside, np.maximum(np.float32(field.around), road.LEAST), field.directions, field.limit, field.origin)
        road.judge(*rasters, position, heading, direction, velocity, valid, size, self.limit, worst, first)
        if len(self._context_size):
            hit, when = _nothing(len(size))
            people = (self._context[0], self._context[1], self._context[3], self._context_size)
            collisions.against(position, heading, valid, size, *people, self.limit[OVERLAP_CONTEXT], hit, when)
            worst[:, OVERLAP_CONTEXT], first[:, OVERLAP_CONTEXT] = hit, when
        broken = stated & ~valid
        if broken.any():
            worst[:, NOT_FINITE] = np.where(broken.any(axis=1), 1.0, NEVER)
            first[:, NOT_FINITE] = np.where(broken.any(axis=1), broken.argmax(axis=1), -1)
        return Severities(worst, first)

    def _field_around(self, position: NDArray[np.float32], valid: NDArray[np.bool_], size: NDArray[np.float32]) -> RoadField:
        """Rasters of the road around all that has been judged so far: most of a map is never looked at."""
        boxes = bounds(position, valid).astype(np.float64)
        reach = float(np.hypot(*size.T).max(initial=0.0)) / 2
        low, high = boxes[:, :2].min(0, initial=np.inf) - reach, boxes[:, 2:].max(0, initial=-np.inf) + reach
        if low[0] > high[0]:  # nobody is anywhere: any part will do
            return self._field or road_field(self._map, np.zeros((1, 2)))
        least, most = self._looked_at
        if self._field is None or (low < least).any() or (high > most).any():
            self._looked_at = least, most = np.minimum(least, low - ROOM), np.maximum(most, high + ROOM)
            self._field = road_field(self._map, np.stack([least, most]))
        return self._field


_Arrays = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]
"""position (..., T, 2), heading (..., T), velocity (..., T, 2), valid (..., T), contiguous as the kernels need them."""


def _arrays(motion: Trajectories) -> _Arrays:
    """The arrays of a motion; a step with a number that is not finite is none, or a kernel would look up cell NaN."""
    position, heading, velocity = (
        np.ascontiguousarray(a, np.float32) for a in (motion.position, motion.heading, motion.velocity)
    )
    valid = np.ascontiguousarray(motion.valid)
    known = _known(position.reshape(-1, 2), heading.ravel(), velocity.reshape(-1, 2), valid.ravel())
    return position, heading, velocity, known.reshape(valid.shape)


@njit(cache=True)
def _among_samples(gates, motion, size, sample, others, other_size, limit, worst, first):  # type: ignore[no-untyped-def]
    """Fill the rules that need others in `worst`, `first` (B, R), for the candidates of one sample after the other."""
    position, heading, velocity, valid = motion
    high = 0
    while high < len(sample):
        low, k = high, sample[high]
        while high < len(sample) and sample[high] == k:
            high += 1
        rows = slice(low, high)
        their = (others[0][k], others[1][k], others[2][k], others[3][k])
        hit, when = np.full(high - low, np.float32(NEVER)), np.full(high - low, np.int16(-1))
        collisions.against(
            position[rows],
            heading[rows],
            valid[rows],
            size[rows],
            their[0],
            their[1],
            their[3],
            other_size,
            limit[OVERLAP],
            hit,
            when,
        )
        worst[rows, OVERLAP], first[rows, OVERLAP] = hit, when
        own = (position[rows], heading[rows], velocity[rows], valid[rows])
        priority.judge(gates, own, size[rows], their, other_size, False, NOBODY, limit, worst[rows], first[rows])


@njit(cache=True, error_model="numpy")
def _known(position, heading, velocity, valid):  # type: ignore[no-untyped-def]
    """Which of M steps are valid, with finite numbers."""
    known = np.empty(len(valid), np.bool_)
    for i in range(len(valid)):
        finite = np.isfinite(position[i, 0]) and np.isfinite(position[i, 1]) and np.isfinite(heading[i])
        known[i] = valid[i] and finite and np.isfinite(velocity[i, 0]) and np.isfinite(velocity[i, 1])
    return known


def _flat(arrays: _Arrays) -> _Arrays:
    position, heading, velocity, valid = arrays
    steps = valid.shape[-1]
    return position.reshape(-1, steps, 2), heading.reshape(-1, steps), velocity.reshape(-1, steps, 2), valid.reshape(-1, steps)


def _nothing(*shape: int) -> tuple[NDArray[np.float32], NDArray[np.int16]]:
    """Severities and first steps before anything was judged."""
    return np.full(shape, NEVER, np.float32), np.full(shape, -1, np.int16)


def check_samples(
    scenario: Scenario, motion: Trajectories, limits: Limits, ignore_target: bool = False
) -> tuple[NDArray[np.uint16], NDArray[np.int16]]:
    """Judge K samples (K, N, T) of one scenario: violation (K, N) and first (K, N). See `SceneChecker.check_samples`."""
    return SceneChecker(scenario, limits).check_samples(motion, ignore_target)
