"""Whatever learns or drives on another device keeps its tensors there: on a GPU, and on `elsewhere`, which stands in for one.

On a GPU numbers agree with the CPU's as well, up to its rounding.
"""

from collections.abc import Iterator
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
from drivegen.planners import paper
from drivegen.planners.shared import latent
from drivegen.planners.shared.guidance import Guidance, Guided, guided
from drivegen.simulators import batch
from drivegen.training import loop
from drivegen.training.curve import LossRow
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


needs_a_gpu = pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU here")


@pytest.fixture(params=["elsewhere", pytest.param("gpu", marks=needs_a_gpu)])
def there(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[torch.device]:
    """The device that everything is to be on, within the test."""
    device = torch.device("cuda") if request.param == "gpu" else ELSEWHERE
    monkeypatch.setattr(loop, "device", lambda: device)
    if device == ELSEWHERE:
        for size in (loop.LATE, latent.CHUNK, paper.CHUNK, paper.PICTURES):
            monkeypatch.setitem(size, ELSEWHERE.type, 16)
        monkeypatch.setattr(torch, "autocast", lambda *_, **__: nullcontext())
        monkeypatch.setattr(torch, "inference_mode", torch.no_grad)
    with second_device() if device == ELSEWHERE else nullcontext():
        yield device


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
@pytest.mark.usefixtures("there")
def test_a_planner_learns_goes_on_and_plans(name: str, tmp_path: Path) -> None:
    logs, planner = examples(2), tiny(name)
    for _ in range(2):  # the second time from the last checkpoint
        planner.fit([logs], logs[:4], 7, tmp_path / "checkpoints", lambda _: None)
    planner.save(tmp_path / "model")
    opened = type(planner).load(tmp_path / "model")
    opened.sample(logs.scenarios, logs.requests).validate()
    if isinstance(opened, Guided):
        cost = lambda motion, _: motion.position[:, -1, 0]  # noqa: E731
        guided(opened, logs.requests, 101, cost, Guidance(1, 1, 0.1))


def fitted(name: str, steps: int) -> list[LossRow]:
    """The curve of rival `name`, a row a step; it is asked to drive, too."""
    values, scenes = read_section(f"train_generator.generators.{name}"), [busy_crossing(61, "crossing")]
    values["training"] |= {"steps": steps, "batch": 4, "report_every": 1}
    plugin = plugins.load("generators", name)
    settings = build(plugin.Settings, values, "tests")
    logs = plugin.examples(settings, scenes)

    def rolled(so_far: Learned) -> float:
        return float(len(so_far.generate(scenes, 1, 7)))

    _, rows = plugin.fit(settings, logs, logs, 7, None, lambda _: None, rolled)
    curve: list[LossRow] = rows
    return curve


@pytest.mark.parametrize("name", RIVALS)
@pytest.mark.usefixtures("there")
def test_a_rival_learns_and_drives(name: str) -> None:
    rows = fitted(name, 1)
    assert np.isfinite([rows[0].train, rows[0].validation]).all()
    assert rows[0].error == 1


@needs_a_gpu
@pytest.mark.parametrize("name", RIVALS)
def test_a_rival_learns_the_same_on_a_gpu(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    there = fitted(name, 4)
    monkeypatch.setattr(loop, "device", lambda: torch.device("cpu"))
    here = fitted(name, 4)
    for losses in ("train", "validation"):
        np.testing.assert_allclose([getattr(row, losses) for row in there], [getattr(row, losses) for row in here], rtol=0.01)


def test_every_driver_sees_and_acts(there: torch.device, tmp_path: Path) -> None:
    scenes, motion = logged(11)
    with torch.no_grad():
        packed = Scenes.of(scenes, motion, device=there)
        view = World(packed, 2, lookout=Lookout.of(packed, scenes, motion)).observe()
        for name, driver in drivers(tmp_path).items():
            assert driver.act(view).acceleration.device.type == there.type, name


@pytest.mark.parametrize("reacting", [False, True])
def test_the_batch_simulator_drives(there: torch.device, reacting: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "CHUNK", 2)
    scenes, motion = logged(41)
    reaction = read_params("environment", Settings).reaction if reacting else None
    chosen = [drivers(tmp_path)[name] for name in DRIVERS]
    ended = batch.Plugin(there.type, reaction, counts_lights=True).run_each(chosen, scenes, motion)
    assert all(np.isfinite(one.motion.position[one.motion.valid]).all() for one in ended)
    if there != ELSEWHERE:
        for one, other in zip(
            ended, batch.Plugin("cpu", reaction, counts_lights=True).run_each(chosen, scenes, motion), strict=True
        ):
            np.testing.assert_allclose(one.motion.position, other.motion.position, atol=0.01)
            np.testing.assert_array_equal(one.step, other.step)


def test_some_of_those_that_are_replayed_can_be_left_out(there: torch.device) -> None:
    scenes, motion = logged(11)
    world = World(packed := Scenes.of(scenes, motion, device=there), 2)
    boxes = Replayed(packed).boxes(world)
    gone = np.ones((2, boxes.valid.shape[1]), np.bool_)
    assert not boxes.without(gone).valid.any()


def driven(motion: str, neighbours: str, device: torch.device) -> tuple[list[np.ndarray], bool]:
    """What two rows of an environment see at each step, and whether any began anew."""
    settings = replace(read_params("environment", Settings), motion=motion, neighbours=neighbours)
    rows = DriveVecEnv(list(zip(*logged(6), strict=True)), 2, settings, device=device.type)
    rows.seed(0)
    rows.reset()
    steps = [rows.step(np.full((2, 2), 0.3, np.float32)) for _ in range(6)]
    assert picture(rows.environment).shape[2] == 3
    return [step[0] for step in steps], any(step[2].any() for step in steps)


@pytest.mark.parametrize(("motion", "neighbours"), [("path_offset", "replayed"), ("free", "reactive")])
def test_an_environment_makes_steps_begins_anew_and_is_drawn(there: torch.device, motion: str, neighbours: str) -> None:
    seen, ended = driven(motion, neighbours, there)
    assert ended
    if there != ELSEWHERE:
        np.testing.assert_allclose(seen, driven(motion, neighbours, torch.device("cpu"))[0], atol=1e-3)
