"""Each faulty driver fails where its fault matters; each equivalent one does what the sound one does."""

from dataclasses import asdict, replace

import numpy as np
import pytest
import torch

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import Signals, SignalState
from drivegen.corner_cases.kinds import Kind
from drivegen.drivers import gail, idm
from drivegen.drivers.mutants.table import EQUIVALENTS, FAULTS, FAULTY, MUTATIONS, Mutant
from drivegen.drivers.shared.network import Settings
from drivegen.drivers.shared.policy import Policy
from drivegen.drivers.shared.version import version
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.world import World
from tests.checking import IDM
from tests.scenes import beside, busy_crossing, crossing, drive, joined, scenario, stack, straight_road

ROAD = straight_road()
LINE = ROAD.centreline[0].astype(np.float64)
STEPS = 101
SOUND = idm.Plugin(replace(IDM, heeds_rules=True))


def behind(other, speed=10.0):
    """A target at x = 10 on the straight road, and one other."""
    return scenario(ROAD, stack([drive(LINE, 10, speed, STEPS), other]))


def red_light():
    roads = crossing(control=LaneControl.SIGNAL)
    states = np.full((1, STEPS), SignalState.RED, np.uint8)
    return scenario(roads, stack([drive(joined(roads, 0, 8, 4), 30, 10, STEPS)]), signals=Signals(np.int32([8]), states))


MERGES = np.array([[43.0, 3.5], [55.0, 0.0], [290.0, 0.0]])
STANDS = drive(LINE, 80, 0, STEPS)
SLOW = drive(LINE, 40, 5, STEPS)
CLOSE = drive(LINE, 32, 0, STEPS)
SCENES = {
    "blind_left": behind(drive(beside(LINE, 1.2), 60, 0, STEPS)),
    "blind_right": behind(drive(beside(LINE, -1.2), 60, 0, STEPS)),
    "short_sight": behind(STANDS),
    "late": behind(STANDS),
    "ignores_merging": behind(drive(MERGES, 0, 2.0, STEPS)),
    "ignores_standing": behind(STANDS),
    "ignores_rules": red_light(),
    "cuts_gaps": behind(SLOW),
    "misjudges_speeds": behind(SLOW),
    "weak_brakes": behind(CLOSE),
    "slow_brakes": behind(CLOSE),
    "distracted": behind(CLOSE),
}
"""What each fault is about; a driver without it collides in none of them."""

BLIND = ("blind_left", "blind_right", "ignores_standing", "ignores_merging", "weak_brakes")
"""Who has these runs into somebody there."""


@pytest.fixture(scope="module")
def network(tmp_path_factory):
    """A policy that nobody taught and that brakes: it answers to whatever it sees."""
    torch.manual_seed(7)
    policy = Policy()
    with torch.no_grad():
        policy.layers[-1].bias.fill_(-0.5)
    folder = tmp_path_factory.mktemp("gail")
    policy.write(folder, "gail")
    return gail.Plugin(Settings(str(folder), sees_rules=True))


def seen_in(scene, steps=25):
    """What a target sees that rolls on, step after step."""
    scenes = Scenes.of([scene, scene], [scene.log, scene.log])
    world = World(scenes, 2, lookout=Lookout.of(scenes, [scene, scene], [scene.log, scene.log]))
    for _ in range(steps):
        yield world.observe()
        world.advance(replace(SOUND.act(world.observe()), acceleration=torch.zeros(2)))


def test_there_are_24_faulty_and_8_equivalent_ones_each_with_its_sentence():
    faulty = [name for name in MUTATIONS if name.split(".")[1] in FAULTS]
    assert (len(faulty), len(MUTATIONS) - len(faulty)) == (24, 8)
    assert sorted(fault for faults in FAULTY.values() for fault in faults) == sorted([*FAULTS, *FAULTS])
    assert all(mutation.line and not mutation.line.endswith(".") for mutation in MUTATIONS.values())
    assert set(EQUIVALENTS) <= set(plugins.names("drivers"))
    assert set(SCENES) == set(FAULTS)


def test_every_faulty_one_says_by_which_kinds_of_collisions_it_should_fail_and_no_equivalent_one_does():
    for name, mutation in MUTATIONS.items():
        assert bool(mutation.fails) == (name.split(".")[1] in FAULTS)
        assert set(mutation.fails) <= set(Kind)


@pytest.mark.parametrize("fault", FAULTY["idm"])
def test_idm_with_a_fault_drives_otherwise_where_the_fault_matters(fault):
    scene = SCENES[fault]
    sound, faulty = (Batch().run(driver, [scene], [scene.log]) for driver in (SOUND, Mutant(f"idm.{fault}", SOUND)))
    assert not sound.collided[0]
    apart = np.abs(np.diff([np.cumsum(np.nan_to_num(one.motion.speed[0])) for one in (sound, faulty)], axis=0)).max() * 0.1
    assert faulty.collided[0] or apart > 2.0
    assert faulty.collided[0] or fault not in BLIND


@pytest.mark.parametrize("fault", FAULTS)  # those of GAIL and SAC together are all
def test_a_network_with_a_fault_acts_otherwise_where_the_fault_matters(fault, network):
    mutant = Mutant(f"{'gail' if fault in FAULTY['gail'] else 'sac'}.{fault}", network)
    changes = [
        float((mutant.act(seen).acceleration - network.act(seen).acceleration).abs().max()) for seen in seen_in(SCENES[fault])
    ]
    assert max(changes) > 0.02


@pytest.mark.parametrize("name", [f"{base}.{name}" for base, several in EQUIVALENTS.items() for name in several])
def test_equivalent_ones_do_the_same_within_rounding(name, network):
    sound = SOUND if name.startswith("idm") else network
    mutant = Mutant(name, sound)
    assert mutant.sees_rules
    for seen in seen_in(busy_crossing(), 60):
        wanted = sound.act(seen).acceleration
        assert mutant.act(seen).acceleration.dtype == wanted.dtype
        assert torch.allclose(mutant.act(seen).acceleration, wanted, atol=1e-3), name


def test_an_equivalent_one_ends_where_the_sound_one_ends():
    scene = busy_crossing()
    ends = [
        Batch().run(driver, [scene], [scene.log]) for driver in (SOUND, *(Mutant(f"idm.{n}", SOUND) for n in EQUIVALENTS["idm"]))
    ]
    assert all(one.kind[0] == ends[0].kind[0] for one in ends)
    assert np.stack([one.end[0] for one in ends]) == pytest.approx(np.tile(ends[0].end[0], (len(ends), 1)), abs=0.01)


def test_a_dotted_name_that_is_no_mutant_is_said_to_be_none():
    with pytest.raises(UnusableInput, match=r"no mutated driver 'idm.blind': there are idm.blind_right, idm"):
        version({"idm.blind": None}, {"idm": asdict(IDM)}, "drivers", "gate.new")
