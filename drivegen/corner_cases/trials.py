"""Trials of a driver in variants of scenes: some tracks of each scene exchanged, everybody else as before.

What scenes have in common (paths, packed traffic, lines ahead) is made once, so a run costs little more than its steps.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.drivers.base import Driver
from drivegen.simulators.batch import CHUNK, Plugin, looks
from drivegen.world.observation import PATH_SPACING
from drivegen.world.outcome import DrivingOutcome
from drivegen.world.reactive import Reaction
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes


@dataclass(frozen=True)
class Variants:
    """V variants of scenes, in which E tracks are exchanged in all.

    Attributes:
        scene: (V,) int64 number of the scene. attacker: (V,) int64 the vehicle that attacks, 0 for none; it does not react.
        row: (E,) int64 the variant that each track belongs to. vehicle: (E,) int64 of the scenario, never the target.
        motion: (E, T).
    """

    scene: NDArray[np.int64]
    attacker: NDArray[np.int64]
    row: NDArray[np.int64]
    vehicle: NDArray[np.int64]
    motion: Trajectories

    @classmethod
    def one_each(cls, scene: NDArray[np.integer], vehicle: NDArray[np.integer], motion: Trajectories) -> "Variants":
        """Variants (V,) of one exchanged track (V, T) each."""
        who = vehicle.astype(np.int64)
        return cls(scene.astype(np.int64), who, np.arange(len(who)), who, motion)

    @classmethod
    def unchanged(cls, scene: NDArray[np.integer], steps: int) -> "Variants":
        """Scenes (V,) as they are."""
        nothing = np.zeros(0, np.int64)
        return cls(scene.astype(np.int64), np.zeros(len(scene), np.int64), nothing, nothing, Trajectories.empty(0, steps))

    @classmethod
    def joined(cls, parts: "Sequence[Variants]") -> "Variants":
        """All parts in order; at least one."""
        before = np.cumsum([0, *map(len, parts)])
        return cls(
            np.concatenate([part.scene for part in parts]),
            np.concatenate([part.attacker for part in parts]),
            np.concatenate([part.row + first for part, first in zip(parts, before[:-1], strict=True)]),
            np.concatenate([part.vehicle for part in parts]),
            Trajectories.joined([part.motion for part in parts]),
        )

    def __len__(self) -> int:
        return len(self.scene)

    def between(self, first: int, last: int) -> "Variants":
        """Variants `first` to `last`, the latter not included."""
        mine = (self.row >= first) & (self.row < last)
        rows = slice(first, last)
        return Variants(
            self.scene[rows], self.attacker[rows], self.row[mine] - first, self.vehicle[mine], self.motion[np.flatnonzero(mine)]
        )


class Trials:
    """Runs of one driver through variants of S scenes.

    Attributes:
        scenarios: (S,) of the scenes. traffic: (S,) everybody's motion (N, T) in them, the target's giving its path.
    """

    def __init__(
        self, driver: Driver, scenarios: Sequence[Scenario], traffic: Sequence[Trajectories], reaction: Reaction | None = None
    ) -> None:
        """Neighbours are replayed unless `reaction` says how they react. Raises UnusableInput for a target that is not there."""
        self.driver, self.scenarios, self.traffic = driver, list(scenarios), list(traffic)
        self._simulator, self._scenes = Plugin(reaction=reaction), Scenes.of(self.scenarios, self.traffic)
        self._lookout: Lookout | None = None
        self._look_out([driver])

    def by(self, driver: Driver) -> "Trials":
        """The same scenes, which are not packed again, with another driver."""
        self._look_out([driver])
        other = copy(self)
        other.driver = driver
        return other

    @property
    def steps(self) -> int:
        """T of the longest scene."""
        return self._scenes.longest

    def path(self, scene: int) -> NDArray[np.float32]:
        """(P, 2) [m] the line that the target of a scene follows, a point every PATH_SPACING."""
        paths = self._scenes.paths
        line: NDArray[np.float32] = paths.point[scene, : int(paths.length[scene] / PATH_SPACING) + 1].cpu().numpy()
        return line

    def run(self, variants: Variants) -> DrivingOutcome:
        """Drive through all variants; what becomes of one does not depend on the others. Empty for none."""
        return self.run_each([self.driver], variants)[0]

    def run_each(self, drivers: Sequence[Driver], variants: Variants) -> list[DrivingOutcome]:
        """As `run` for each of several drivers; variants are made once for all."""
        if not len(variants):
            return [DrivingOutcome.none(self.steps)] * len(drivers)
        self._look_out(drivers)
        parts = [self._chunk(drivers, variants.between(low, low + CHUNK)) for low in range(0, len(variants), CHUNK)]
        return [DrivingOutcome.joined(column) for column in zip(*parts, strict=True)]

    def _look_out(self, drivers: Sequence[Driver]) -> None:
        """Make what drivers see of rules, once any of these looks for it."""
        if self._lookout is None and any(map(looks, drivers)):
            self._lookout = Lookout.of(self._scenes, self.scenarios, self.traffic)

    def _chunk(self, drivers: Sequence[Driver], some: Variants) -> list[DrivingOutcome]:
        chosen = np.resize(some.scene, CHUNK)  # padded by repeating: shapes stay the same, so do bytes
        scenes = self._scenes.exchanged(chosen, some.row, some.vehicle, some.motion)
        seen = self._lookout if any(map(looks, drivers)) else None
        lookout = seen.exchanged(scenes, chosen, some.row, some.vehicle) if seen else None
        scenarios = [self.scenarios[s] for s in some.scene.tolist()]
        return [self._simulator.drive(driver, scenes, scenarios, self.steps, some.attacker, lookout) for driver in drivers]
