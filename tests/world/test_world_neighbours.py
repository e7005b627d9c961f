"""Neighbours that react: undisturbed they do what was planned; for a target in their way they brake, late and not too hard."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from drivegen.core.scenario import Actors, Trajectories
from drivegen.simulators.batch import Plugin
from drivegen.world.observation import Action
from drivegen.world.outcome import CollisionKind
from drivegen.world.reactive import LATE, Reaction, Reactive
from drivegen.world.scenes import Scenes
from drivegen.world.world import World
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road

LAW = Reaction(delay=0.75, braking=6.0, headway=0.6, min_gap=1.0, acceleration=1.5, comfort=3.0)
ROAD = straight_road(600)
LINE = ROAD.centreline[0].astype(np.float64)
NEXT = ROAD.centreline[1].astype(np.float64)


class Braking:
    """Brakes by `rate` [m/s2] from step `since` on, until it stands."""

    name = "braking"

    def __init__(self, rate, since=0):
        self.rate, self.since = rate, since

    def act(self, seen):
        return Action(torch.where(seen.step >= self.since, -self.rate, 0.0) + 0 * seen.speed)


class AsLogged:
    """Drives at the speed of its log."""

    name = "as logged"

    def __init__(self, log):
        self.speed = torch.from_numpy(log.speed[0])

    def act(self, seen):
        return Action((self.speed[int(seen.step[0]) + 1] - seen.speed) / 0.1)


def lived(driver, log, scene=None, attacker=None, **more):
    """The world after every step, and the others' positions (T, M, 2)."""
    scenes = Scenes.of([scene or scenario(ROAD, log)], [log])
    world = World(scenes, 1, Reactive(scenes, 1, LAW, attacker, **more))
    positions = [world.neighbours.boxes(world).position[0].clone()]
    for _ in range(scenes.longest - 1):
        world.advance(driver.act(world.observe()))
        positions.append(world.neighbours.boxes(world).position[0].clone())
    return world, torch.stack(positions).numpy()


def test_undisturbed_everybody_is_where_it_was_logged_to_be():
    base = busy_crossing()
    world, positions = lived(AsLogged(base.log), base.log, base)
    assert np.abs(positions[:, : len(base.log.valid) - 1] - base.log.position[1:].swapaxes(0, 1)).max() < 1e-4
    assert float(world.neighbours.taken) == 0


def test_a_target_that_stops_in_front_is_braked_for_after_the_delay():
    log = stack([drive(LINE, 60, 10, 101), drive(LINE, 40, 10, 101)])
    [replayed] = Plugin().run(Braking(6.0), [scenario(ROAD, log)], [log]).kind
    reacting = Plugin(reaction=LAW).run(Braking(6.0), [scenario(ROAD, log)], [log])
    assert replayed == CollisionKind.HIT_STANDING
    assert reacting.kind[0] == CollisionKind.NONE
    assert 3.0 < reacting.imposed_braking[0] <= 6.0 + 1e-3
    assert reacting.imposed_loss[0] > 5.0
    world, positions = lived(Braking(6.0), log)
    first = int(np.argmax(np.diff(positions[:, 0, 0]) < 0.99))
    assert 8 <= first <= 25  # it notices once following asks for it, and begins 0.75 s later
    assert float(world.neighbours.speed[0, 0]) < 0.5


@pytest.mark.parametrize("steps", [4, 8, 24, 30])
def test_a_delay_of_whole_steps_is_that_many(monkeypatch, steps):
    log, begun = stack([drive(LINE, 60, 10, 101), drive(LINE, 10, 10, 101)]), []
    for delay in (0.1 * steps - 0.05, 0.1 * steps):
        monkeypatch.setattr(f"{__name__}.LAW", replace(LAW, delay=delay))
        speed = np.diff(lived(Braking(3.0), log)[1][:, 0, 0])
        begun.append(int(np.argmax(speed < 0.99)))
    assert begun[0] == begun[1] > steps


def test_braking_is_bounded_so_that_a_target_may_still_be_hit():
    log = stack([drive(LINE, 60, 20, 101), drive(LINE, 52, 20, 101)])
    outcome = Plugin(reaction=LAW).run(Braking(9.0), [scenario(ROAD, log)], [log])
    assert outcome.collided[0]
    assert outcome.imposed_braking[0] == pytest.approx(6.0, abs=1e-3)
    assert 0 < outcome.impact_speed[0] < 15


def test_what_is_imposed_after_the_run_has_ended_does_not_count():
    """The target runs into a parked car; somebody far behind would have to brake for the wreck later."""
    log = stack([drive(LINE, 60, 10, 101), drive(LINE, 75, 0, 101), drive(LINE, 10, 10, 101)])
    outcome = Plugin(reaction=LAW).run(Braking(0.0), [scenario(ROAD, log)], [log])
    assert outcome.partner[0] == 1
    assert outcome.imposed_braking[0] == 0
    world, _ = lived(Braking(6.0, since=11), log)
    assert float(world.neighbours.hardest) > 0


def test_the_attacker_does_not_react():
    log = stack([drive(LINE, 60, 10, 101), drive(LINE, 40, 10, 101)])
    for attacker, kind in ((1, CollisionKind.HIT_STANDING), (0, CollisionKind.NONE)):
        run = Plugin(reaction=LAW).run(Braking(6.0), [scenario(ROAD, log)], [log], attacker=np.array([attacker]))
        assert run.kind[0] == kind


def test_who_follows_one_that_brakes_brakes_too_and_who_drives_beside_does_not():
    cars = [drive(LINE, 60, 10, 101), drive(LINE, 45, 10, 101), drive(LINE, 30, 10, 101), drive(NEXT, 50, 10, 101)]
    world, positions = lived(Braking(6.0), stack(cars))
    late = (world.neighbours.clock < world.step[:, None] - LATE)[0, :3].tolist()
    assert late == [True, True, False]
    assert positions[-1, 1, 0] + 4.6 < positions[-1, 0, 0]  # no pile-up
    assert positions[-1, 2, 0] == pytest.approx(150, abs=0.1)


def test_who_reacts_to_the_target_alone_does_not_mind_who_brakes_for_it():
    cars = stack([drive(LINE, 60, 10, 101), drive(LINE, 45, 10, 101), drive(LINE, 33, 10, 101)])
    gaps = [lived(Braking(6.0), cars, to_target_alone=alone)[1][-1] for alone in (False, True)]
    minds, runs_on = (float(at[0, 0] - at[1, 0]) - 4.6 for at in gaps)
    assert minds > 0 > runs_on


def test_it_goes_on_when_the_way_is_free_again_and_waits_no_longer_than_its_plan_does():
    class Pausing(Braking):
        def act(self, seen):
            return Action(torch.where(seen.step < 30, -6.0, 3.0) + 0 * seen.speed)

    world, positions = lived(Pausing(6.0), stack([drive(LINE, 60, 10, 201), drive(LINE, 40, 10, 201)]))
    assert float(world.neighbours.speed[0, 0]) == pytest.approx(10, abs=0.1)
    assert positions[-1, 0, 0] < 240 - 5
    waits = drive(LINE, 40, 10, 201, -2.5)  # stands at 60 m from 4 s on
    late = drive(LINE, 40, 10, 201)
    late.position[40:, 0] = np.where(np.arange(40, 201) < 120, 60, 60 + (np.arange(40, 201) - 120))[:]
    late.position[:40], late.velocity[:40] = waits.position[:40], waits.velocity[:40]
    late.velocity[40:120] = 0
    world, positions = lived(Pausing(6.0), stack([drive(LINE, 56, 10, 201), late]))
    assert np.abs(positions[-1, 0] - late.position[-1]).max() < 1e-3


def test_people_are_replayed_and_those_who_are_late_brake_for_them():
    walker = Trajectories.empty(1, 101)
    walker.position[:], walker.valid[:] = [90.0, 0.0], np.arange(101) >= 70
    people = Actors(np.array(["p"]), np.array([5], np.uint8), np.float32([[0.6, 0.6, 1.8]]), walker)
    log = stack([drive(NEXT, 60, 10, 101), drive(LINE, 40, 10, 101)])
    scene = replace(scenario(ROAD, log), context=people)
    _, positions = lived(AsLogged(log), log, scene)
    assert positions[-1, 0, 0] == pytest.approx(140, abs=0.1)  # on time it was planned past them
    assert (positions[:, 1] == [90.0, 0.0]).all()


def test_a_row_depends_on_itself_alone():
    log = stack([drive(LINE, 60, 10, 101), drive(LINE, 45, 10, 101), drive(LINE, 30, 10, 101)])
    scenes = [scenario(ROAD, log), busy_crossing()]
    both = Plugin(reaction=LAW).run(Braking(5.0), scenes, [s.log for s in scenes])
    for i, scene in enumerate(scenes):
        alone = Plugin(reaction=LAW).run(Braking(5.0), [scene], [scene.log])
        assert np.array_equal(alone.motion.position[0], both.motion.position[i])
        assert alone.imposed_loss[0] == both.imposed_loss[i]
        assert alone.step[0] == both.step[i]
