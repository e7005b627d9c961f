"""What became of a driver's runs: how far they went, how they ended, who was hit and how."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core.geometry import box_corners
from drivegen.core.scenario import FIRST_SECOND, TARGET, Scenario, Trajectories
from drivegen.roads.drivable import road_surface

NO_PARTNER = -1


class CollisionKind(IntEnum):
    """Who hit whom, by the faces of the boxes that meet first (`contact.py`)."""

    NONE = 0
    AT_SPAWN = 1
    """The boxes overlap as the other appears: at step 0, or where its track begins or goes on after a gap."""
    FRONT = 2
    """The target ran into the other with its front."""
    SIDE = 3
    """Side met side, or the other's rear: nobody's front was in it."""
    HIT_IN_SIDE = 4
    """The other ran with its front into the target's side."""
    HIT_FROM_BEHIND = 5
    """The other ran into the target's rear; a replay can't brake."""
    HIT_STANDING = 6
    """The target stood still."""


AT_FAULT = (CollisionKind.FRONT, CollisionKind.SIDE)
"""Kinds that count against the driver; the others are done to it."""


ARTEFACTS = (CollisionKind.AT_SPAWN, CollisionKind.HIT_FROM_BEHIND, CollisionKind.HIT_STANDING)
"""Kinds that say more of the traffic than of the driver: the other, a replay perhaps, did not mind it."""


@dataclass(frozen=True)
class DrivingOutcome:
    """What became of S targets.

    Attributes:
        kind: (S,) uint8 CollisionKind of the first collision.
        step: (S,) int16 of it, -1 if none.
        partner: (S,) int32 index into the scenario's vehicles, or number of vehicles + index into its context actors;
            NO_PARTNER if none.
        left_map: (S,) bool the target has driven out by an exit of the map, which ends its run well.
        motion: Trajectories (S, T) of the targets, valid up to and including the collision, or until it left the map; shorter
            scenarios end earlier.
        contact: (S,) uint8 nuPlan's type of the collision, and at_fault: (S,) bool its verdict (`fault.py`).
        impact_speed: (S,) float32 [m/s] of the two relative to one another, NaN without a collision.
        imposed_braking: (S,) float32 [m/s2] the hardest that a neighbour braked for the target, and imposed_loss: (S,) float32
            [m/s] the speed that this took from all of them; 0 where neighbours are replayed.
        red_lights: (S,) float32 that the target came near, and red_run: (S,) of these that it ran; NaN where nobody looked.
        off_road: (S,) float32 share of valid steps with a corner off the drivable area; NaN until `with_off_road` judges it.
    """

    kind: NDArray[np.uint8]
    step: NDArray[np.int16]
    partner: NDArray[np.int32]
    left_map: NDArray[np.bool_]
    motion: Trajectories
    contact: NDArray[np.uint8]
    at_fault: NDArray[np.bool_]
    impact_speed: NDArray[np.float32]
    imposed_braking: NDArray[np.float32]
    imposed_loss: NDArray[np.float32]
    red_lights: NDArray[np.float32]
    red_run: NDArray[np.float32]
    off_road: NDArray[np.float32]

    def __getitem__(self, index: Any) -> "DrivingOutcome":
        """The outcomes that `index` chooses."""
        return DrivingOutcome(*(getattr(self, f.name)[index] for f in fields(self)))

    @classmethod
    def none(cls, steps: int) -> "DrivingOutcome":
        """Of no target, over `steps` steps."""
        number = np.zeros(0, np.float32)
        return cls(
            kind=np.zeros(0, np.uint8),
            step=np.zeros(0, np.int16),
            partner=np.zeros(0, np.int32),
            left_map=np.zeros(0, np.bool_),
            motion=Trajectories.empty(0, steps),
            contact=np.zeros(0, np.uint8),
            at_fault=np.zeros(0, np.bool_),
            impact_speed=number,
            imposed_braking=number,
            imposed_loss=number,
            red_lights=number,
            red_run=number,
            off_road=number,
        )

    @classmethod
    def joined(cls, parts: "Sequence[DrivingOutcome]") -> "DrivingOutcome":
        """The outcomes of several runs, one after the other."""
        joined: dict[str, Any] = {f.name: [getattr(part, f.name) for part in parts] for f in fields(cls) if f.name != "motion"}
        motion = Trajectories.joined([part.motion for part in parts])
        return cls(motion=motion, **{name: np.concatenate(arrays) for name, arrays in joined.items()})

    @property
    def to_the_end(self) -> Trajectories:
        """(S, T) the targets' motion, standing where a run ended in a collision and gone where it left the map."""
        return replace(self.motion.standing_after_end(), valid=self.motion.valid | ~self.left_map[:, None])

    @property
    def collided(self) -> NDArray[np.bool_]:
        """(S,)."""
        return np.not_equal(self.kind, CollisionKind.NONE)

    @property
    def in_first_second(self) -> NDArray[np.bool_]:
        """(S,) collided within the first second, overlaps at spawn included."""
        return self.collided & (self.step <= FIRST_SECOND)

    @property
    def artefact(self) -> NDArray[np.bool_]:
        """(S,) ended in a collision that is counted apart: of ARTEFACTS, or within the first second."""
        return np.isin(self.kind, ARTEFACTS) | self.in_first_second

    @property
    def counted(self) -> NDArray[np.bool_]:
        """(S,) ended in a collision that says something of the driver.

        FRONT, SIDE or HIT_IN_SIDE after the first second: neither run into from behind nor while standing, nor too early for
        anybody.
        """
        return np.asarray(self.collided & ~self.artefact)

    @property
    def end(self) -> NDArray[np.float32]:
        """(S, 2) last position [m]."""
        return self.motion.position[np.arange(len(self.kind)), self.motion.last_valid()]


OFF_ROAD_TOLERANCE = 0.3
"""A corner farther out than this [m] is off the road."""


def with_off_road(outcome: DrivingOutcome, scenarios: Sequence[Scenario]) -> DrivingOutcome:
    """The outcome with `off_road` filled in; scenarios that share a map object share its raster."""
    rows: dict[int, list[int]] = {}
    for s, scenario in enumerate(scenarios):
        rows.setdefault(id(scenario.map), []).append(s)
    share = np.full(len(scenarios), np.nan, np.float32)
    for same in rows.values():
        motion = outcome.motion[same]
        size = np.stack([scenarios[s].vehicles.size[TARGET] for s in same])[:, np.newaxis]
        corners = box_corners(motion.position, motion.heading, size[..., 0], size[..., 1])
        surface = road_surface(scenarios[same[0]].map, corners[motion.valid].reshape(-1, 2))
        out = surface.distance_outside(corners).max(axis=-1) > OFF_ROAD_TOLERANCE
        share[same] = np.mean(out, axis=-1, where=motion.valid)
    return replace(outcome, off_road=share)
