"""What the legal checker turned down while a scenario's samples were made, and what was then planned again; to be looked at."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import arc_length, interpolate
from drivegen.core.samples import Samples, Violation
from drivegen.core.scenario import Trajectories

MADE_WAY = "made way"
"""The reason of who was legal and taken back, because another vehicle found no way past it."""


@dataclass(frozen=True)
class Rejected:
    """R trajectories of one scenario that were planned, judged and replaced by others, in the order of their judgement.

    Attributes:
        scenario_id: the scenario they belong to.
        method: who planned them.
        position: (R, T, 2) float32 [m] where each would have gone.
        sample: (R,) int32 in which of the K samples. vehicle: (R,) int32 whose it is.
        violation: (R,) uint16 `samples.Violation` flags, against what the sample had committed then.
        made_way: (R,) bool it was legal at first; its COLLISION is with the one that it made way for.
    """

    scenario_id: str
    method: str
    position: NDArray[np.float32]
    sample: NDArray[np.int32]
    vehicle: NDArray[np.int32]
    violation: NDArray[np.uint16]
    made_way: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.sample)

    def only(self, mask: NDArray[np.bool_]) -> "Rejected":
        """Those that are `mask` (R,)."""
        return Rejected(
            self.scenario_id,
            self.method,
            self.position[mask],
            self.sample[mask],
            self.vehicle[mask],
            self.violation[mask],
            self.made_way[mask],
        )

    def dashes(self, length: float) -> NDArray[np.float32]:
        """(D, 2, 2) [m] both ends of dashes so long, with gaps twice as long, along all of them; none of who stands still.

        They begin where each trajectory does, so those of one vehicle along one road don't fill each other's gaps.
        """
        lines = []
        for path in self.position:
            start = np.arange(0.0, float(arc_length(path)[-1]), 3 * length)
            lines.append(np.stack([interpolate(path, start), interpolate(path, start + length)], axis=1))
        return np.concatenate([np.zeros((0, 2, 2), np.float32), *lines])

    @property
    def reasons(self) -> dict[str, int]:
        """How many broke which rule, the commonest first; one that broke several counts for each of them."""
        judged = self.violation[~self.made_way]
        counts = {_words(kind): int(np.count_nonzero(judged & kind)) for kind in Violation if kind}
        counts[MADE_WAY] = int(self.made_way.sum())
        return {reason: n for reason, n in sorted(counts.items(), key=lambda item: -item[1]) if n}

    @property
    def summary(self) -> str:
        """As "3 turned down: 2 collision, 1 off road"."""
        why = ", ".join(f"{n} {reason}" for reason, n in self.reasons.items())
        return f"{len(self)} turned down: {why}" if why else "none turned down"


class Rejections:
    """Collects them while one scenario is rolled out; whoever wants none gives the rollout no such list."""

    def __init__(self) -> None:
        self._rows: list[tuple[int, int, int, int, int]] = []
        self._position: list[NDArray[np.float32]] = []

    def add(self, when: tuple[int, int, int], vehicle: int, violation: int, position: NDArray[np.float32]) -> None:
        """Note a trajectory (T, 2) of a vehicle; it is copied.

        `when` are the round, the sample and the vehicle that was judged: another one where this one made way for it.
        """
        self._rows.append((*when, vehicle, violation))
        self._position.append(position.copy())

    def replaced_in(self, samples: Samples) -> Rejected:
        """All but those that stand in `samples` in the end: the least illegal one stays where nothing legal was found."""
        turn, sample, judged, vehicle, violation = np.array(self._rows, np.int64).reshape(-1, 5).T
        steps = samples.motion.valid.shape[-1]
        position = np.stack(self._position) if self._position else np.zeros((0, steps, 2), np.float32)
        order = np.lexsort((judged, sample, turn))  # stable: those of one judgement stay as they were tried
        rejected = Rejected(
            scenario_id=samples.scenario_id,
            method=samples.method,
            position=position[order].astype(np.float32),
            sample=sample[order].astype(np.int32),
            vehicle=vehicle[order].astype(np.int32),
            violation=violation[order].astype(np.uint16),
            made_way=(vehicle != judged)[order],
        )
        return rejected.only(~_stand(rejected, samples.motion))


def _stand(rejected: Rejected, motion: Trajectories) -> NDArray[np.bool_]:
    """(R,) which of them are what the samples (K, N, T) hold; of who has left the map the last pose is repeated."""
    place = (rejected.sample, rejected.vehicle)
    same = np.equal(rejected.position, motion.position[place]).all(axis=(1, 2))
    return np.asarray(same & motion.valid[place].any(axis=1))


def _words(kind: Violation) -> str:
    return str(kind.name).lower().replace("_", " ")
