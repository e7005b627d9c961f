"""Whatever learns or drives on another device keeps its tensors there; `elsewhere` stands in for a GPU."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from drivegen.core import plugins
from drivegen.core.scenario import Scenario
from drivegen.core.settings import build, read_params, read_section
from drivegen.drivers.base import Driver
from drivegen.drivers.mutants.table import mutated
from drivegen.drivers.shared.conditions import Settings
from drivegen.drivers.shared.policy import Policy
from drivegen.generators.shared.learned import Learned
from drivegen.gym.picture import picture
from drivegen.gym.sb3 import DriveVecEnv
from drivegen.planners.shared import latent
from drivegen.planners.shared.guidance import Guidance, Guided, guided
from drivegen.simulators import batch
from drivegen.training import loop
from drivegen.world.neighbours import Replayed
from drivegen.world.rules import Lookout
from drivegen.world.scenes import Scenes
from drivegen.world.world import World
from tests.drivers.taught import settings_of
from tests.planners.tiny import examples, tiny
from tests.scenes import busy_crossing
from tests.training.elsewhere import ELSEWHERE, second_device

RIVALS = [name for name in plugins.names("generators") if name in read_section("train_generator.generators")]
DRIVERS = ("idm", "gail", "sac")

pytestmark = pytest.mark.filterwarnings("ignore:for .*copying from a non-meta parameter")


@pytest.fixture(autouse=True)
def other_device(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop, "device", lambda: ELSEWHERE)
    monkeypatch.setitem(latent.CHUNK, ELSEWHERE.type, 16)
    monkeypatch.setattr(torch, "autocast", lambda *_, **__: nullcontext())
    monkeypatch.setattr(torch, "inference_mode", torch.no_grad)


def drivers(folder: Path) -> dict[str, Driver]:
    """One of each kind, and all that is wrong with them; networks know nothing yet."""
    made: dict[str, Driver] = {}
    for name in DRIVERS:
        settings = settings_of(name)
        if hasattr(settings, "weights"):
            Policy().write(folder / name, name)
            settings = replace(settings, weights=str(folder / name))
        made[name] = plugins.load("drivers", name)(settings)
    return made | mutated(made)


def logged(steps: int) -> tuple[list[Scenario], list]:
    scenes = [busy_crossing(steps, "one"), busy_crossing(steps, "two")]
    return scenes, [scene.log for scene in scenes]


def test_tensors_of_two_devices_do_not_meet_here_either() -> None:
    with second_device():
        far, near = torch.arange(3.0).to(ELSEWHERE), torch.ones(3)
        assert far.device == ELSEWHERE
        assert (far + far.new_tensor([1.0, 2.0, 3.0])).cpu().tolist() == [1.0, 3.0, 5.0]
        with pytest.raises(RuntimeError, match="two devices"):
            far + near
        with pytest.raises(RuntimeError, match="two devices"):
            near[far.long()]
        with pytest.raises(RuntimeError, match="generator"):
            torch.rand(3, device=ELSEWHERE, generator=torch.Generator())
        with pytest.raises((RuntimeError, TypeError)):
            far.numpy()


@pytest.mark.parametrize("name", plugins.names("planners"))
def test_a_planner_learns_goes_on_and_plans(name: str, tmp_path: Path) -> None:
    logs, planner = examples(2), tiny(name)
    with second_device():
        for _ in range(2):  # the second time from the last checkpoint
            planner.fit([logs], logs[:4], 7, tmp_path / "checkpoints", lambda _: None)
        planner.save(tmp_path / "model")
        opened = type(planner).load(tmp_path / "model")
        there = opened.sample(logs.scenarios, logs.requests)
        if isinstance(opened, Guided):
            cost = lambda motion, _: motion.position[:, -1, 0]  # noqa: E731
            guided(opened, logs.requests, 101, cost, Guidance(1, 1, 0.1))
    there.validate()


@pytest.mark.parametrize("name", RIVALS)
def test_a_rival_learns_and_drives(name: str) -> None:
    values, scenes = read_section(f"train_generator.generators.{name}"), [busy_crossing(61, "crossing")]
    values["training"] |= {"steps": 1, "batch": 4, "report_every": 1}
    plugin = plugins.load("generators", name)
    settings = build(plugin.Settings, values, "tests")
    logs = plugin.examples(settings, scenes)

    def rolled(so_far: Learned) -> float:
        return float(len(so_far.generate(scenes, 1, 7)))

    with second_device():
        _, rows = plugin.fit(settings, logs, logs, 7, None, lambda _: None, rolled)
    assert np.isfinite([rows[0].train, rows[0].validation]).all()
    assert rows[0].error == 1


def test_every_driver_sees_and_acts(tmp_path: Path) -> None:
    scenes, motion = logged(11)
    with second_device(), torch.no_grad():
        packed = Scenes.of(scenes, motion, device=ELSEWHERE)
        view = World(packed, 2, lookout=Lookout.of(packed, scenes, motion)).observe()
        for name, driver in drivers(tmp_path).items():
            assert driver.act(view).acceleration.device == ELSEWHERE, name


@pytest.mark.parametrize("reacting", [False, True])
def test_the_batch_simulator_drives(reacting: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "CHUNK", 2)
    scenes, motion = logged(11)
    reaction = read_params("environment", Settings).reaction if reacting else None
    with second_device():
        simulator = batch.Plugin(ELSEWHERE.type, reaction, counts_lights=True)
        ended = simulator.run_each([drivers(tmp_path)[name] for name in DRIVERS], scenes, motion)
    assert all(np.isfinite(one.motion.position[one.motion.valid]).all() for one in ended)


def test_some_of_those_that_are_replayed_can_be_left_out() -> None:
    scenes, motion = logged(11)
    with second_device():
        world = World(packed := Scenes.of(scenes, motion, device=ELSEWHERE), 2)
        boxes = Replayed(packed).boxes(world)
        gone = np.ones((2, boxes.valid.shape[1]), np.bool_)
        assert not boxes.without(gone).valid.any()


@pytest.mark.parametrize(("motion", "neighbours"), [("path_offset", "replayed"), ("free", "reactive")])
def test_an_environment_makes_steps_begins_anew_and_is_drawn(motion: str, neighbours: str) -> None:
    settings = replace(read_params("environment", Settings), motion=motion, neighbours=neighbours)
    with second_device():
        rows = DriveVecEnv(list(zip(*logged(6), strict=True)), 2, settings, device=ELSEWHERE.type)
        rows.seed(0)
        rows.reset()
        ended = [rows.step(np.full((2, 2), 0.3, np.float32))[2] for _ in range(6)]
        assert picture(rows.environment).shape[2] == 3
    assert np.any(ended)
