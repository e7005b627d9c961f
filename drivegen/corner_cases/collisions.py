"""Collisions of a driver as they are shown to somebody: which ones, in words, and in a picture from above.

Paper, "Processing Failed Examples": "visual trajectory collision images" go to the model beside the statistics.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drivegen.core.samples import Samples
from drivegen.core.scenario import DT, TARGET, Scenario, Trajectories
from drivegen.corner_cases.encounters import LOOK_BACK, Behaviour, Direction
from drivegen.corner_cases.knowledge import Knowledge, speed_names
from drivegen.corner_cases.rounds import Drive, encounters_of, taught
from drivegen.render.png import png
from drivegen.render.scene_picture import View, scene_picture
from drivegen.rollout.choices import Choices
from drivegen.world.outcome import CollisionKind

WIDTH = 90.0
"""[m] across a picture."""

PIXELS = 448

_DIRECTIONS = {
    Direction.SAME: "going the same way",
    Direction.FROM_LEFT: "coming from the target's left",
    Direction.FROM_RIGHT: "coming from the target's right",
    Direction.OPPOSITE: "oncoming",
}
_KINDS = {
    CollisionKind.FRONT: "the target ran into it with its front",
    CollisionKind.SIDE: "their sides met",
    CollisionKind.HIT_IN_SIDE: "it ran into the target's side",
}


@dataclass(frozen=True)
class Collision:
    """One collision that knowledge is made of.

    Attributes:
        sample: of the round's samples of the scenario. partner: the other vehicle. step: of the impact. kind: CollisionKind.
        cell: bins of relative speed, direction and behaviour (`Encounters`).
    """

    scenario_id: str
    sample: int
    partner: int
    step: int
    kind: int
    cell: tuple[int, int, int]


def collisions(choice: Choices, drive: Drive) -> list[Collision]:
    """All of one scenario's runs, by sample."""
    met, hit = encounters_of(drive, choice), taught(drive, choice)
    return [
        Collision(
            choice.scenario.scenario_id,
            k,
            n + 1,
            int(drive.outcome.step[k]),
            int(drive.outcome.kind[k]),
            (int(met.speed_bin[k, n]), int(met.direction[k, n]), int(met.behaviour[k, n])),
        )
        for k, n in np.argwhere(hit).tolist()
    ]


def telling(collisions: Sequence[Collision], knowledge: Knowledge, most: int) -> list[Collision]:
    """At most `most`, the riskiest features first, one of each scenario and no features twice while there are others."""
    risk = knowledge.probability()
    order = sorted(collisions, key=lambda c: (-risk[c.cell], c.scenario_id, c.sample, c.partner))
    chosen: list[Collision] = []
    for others_only in (True, False):
        for one in order:
            scenes, cells = {c.scenario_id for c in chosen}, {c.cell for c in chosen}
            if len(chosen) < most and one.scenario_id not in scenes and not (others_only and one.cell in cells):
                chosen.append(one)
    return chosen


def in_words(one: Collision, knowledge: Knowledge) -> str:
    """What the picture shows, for somebody who cannot know its colours."""
    speed, direction, behaviour = one.cell
    return (
        f"A collision of the target (orange, its way orange) with another vehicle (its way red), after {one.step * DT:.1f} s: "
        f"{_KINDS[CollisionKind(one.kind)]}. The other was {_DIRECTIONS[Direction(direction)]}, "
        f"{Behaviour(behaviour).name.lower().replace('_', ' ')}, relative speed {speed_names()[speed]} m/s. Of such encounters "
        f"{knowledge.probability()[one.cell]:.3f} end in a collision. Boxes stand where vehicles were at the impact, lines are "
        f"their last {LOOK_BACK * DT:.0f} seconds; others are blue."
    )


def picture(one: Collision, scenario: Scenario, traffic: Samples, driven: Trajectories) -> bytes:
    """PNG of the moment of impact around the target, with everybody's way there; `driven` (K, T) are the driven targets."""
    moved = Trajectories.joined([driven[one.sample : one.sample + 1], traffic.motion[one.sample, 1:]])
    since = max(one.step - LOOK_BACK, 0)
    here = moved.between(one.step, one.step + 1)
    there = here.valid[:, 0]
    vehicles = scenario.vehicles[there]
    vehicles = replace(vehicles, position=here.position[there, 0], heading=here.heading[there, 0], speed=here.speed[there, 0])
    context = replace(scenario.context, motion=scenario.context.motion.between(one.step, one.step + 1))
    signals = replace(scenario.signals, state=scenario.signals.state[:, one.step : one.step + 1])
    moment = replace(scenario, vehicles=vehicles, context=context, signals=signals, log=None)
    way = moved[there].between(since, one.step + 1)
    red = np.zeros(len(there), np.bool_)
    red[one.partner : one.partner + 1] = True  # a person is none of the vehicles
    view = View(here.position[TARGET, 0], WIDTH, PIXELS)
    return png(scene_picture(moment, way[np.newaxis], red[there][np.newaxis], view=view))
