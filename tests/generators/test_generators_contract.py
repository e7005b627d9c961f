"""What every scenario generator promises, with models that were trained for seconds."""

import copy
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivegen.core import plugins
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.geometry import boxes_overlap
from drivegen.core.methods import BOUND, LOGS, NOTHING, read_methods
from drivegen.core.samples import NO_GOAL, Samples
from drivegen.core.scenario import TARGET, Scenario
from drivegen.generators.base import Generator, Settings
from drivegen.generators.shared.learned import Learned
from stages import rollout
from stages._door import read_params
from tests.generators.rivals import fitted, same, trained
from tests.generators.rivals import scenes as three_scenes

NAMES = plugins.names("generators")
SAMPLES = 3
COLUMNS = ("violation", "first_violation", "goal", "natural", "used", "attempts", "dropped")


@pytest.fixture(scope="module")
def settings() -> Settings:
    return read_params("rollout", rollout.Params).generation


@pytest.fixture(scope="module")
def scenes() -> list[Scenario]:
    """Different numbers of vehicles and lengths in one batch."""
    return three_scenes()


def learns(name: str) -> bool:
    plugin = plugins.load("generators", name)
    return isinstance(plugin, type) and issubclass(plugin, Learned)


@pytest.fixture(scope="module")
def rivals(models: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The pipeline's models with the trained weights of one rival beside them."""
    folder = tmp_path_factory.mktemp("rivals")
    shutil.copytree(models, folder, dirs_exist_ok=True)

    def with_weights(name: str) -> Path:
        weights = plugins.load("generators", name).name if learns(name) else ""
        if learns(name) and not (folder / "generators" / weights).exists():
            trained(weights)[0].save(folder / "generators" / weights)
        return folder

    return with_weights


@pytest.fixture(scope="module", params=NAMES)
def generator(request: pytest.FixtureRequest, rivals: Callable[[str], Path], settings: Settings) -> Generator:
    made: Generator = plugins.load("generators", request.param)(rivals(request.param), settings)
    return made


@pytest.fixture(scope="module")
def made(generator: Generator, scenes: list[Scenario]) -> list[Samples]:
    return generator.generate(scenes, SAMPLES, 7)


@pytest.mark.parametrize("name", NAMES)
def test_what_its_file_says_of_it_is_what_it_says_itself(name: str) -> None:
    assert plugins.load("generators", name).about == read_methods()[name]


def assert_same(one: Samples, other: Samples) -> None:
    for name in ("position", "heading", "velocity", "valid"):
        np.testing.assert_array_equal(getattr(one.motion, name), getattr(other.motion, name))
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_there_are_k_finite_futures_of_every_vehicle(generator: Generator, scenes: list[Scenario], made: list[Samples]) -> None:
    assert generator.backend
    assert [s.scenario_id for s in made] == [s.scenario_id for s in scenes]
    for scene, samples in zip(scenes, made, strict=True):
        shape = (SAMPLES, len(scene.vehicles))
        assert samples.motion.valid.shape == (*shape, scene.steps)
        assert {getattr(samples, name).shape for name in COLUMNS} == {shape}
        samples.motion.validate()
        assert samples.motion.valid.all()
        assert not samples.dropped.any()
        assert samples.method


def test_every_future_begins_in_the_given_state(scenes: list[Scenario], made: list[Samples]) -> None:
    for scene, samples in zip(scenes, made, strict=True):
        for k in range(SAMPLES):
            np.testing.assert_array_equal(samples.motion.position[k, :, 0], scene.vehicles.position)
            np.testing.assert_array_equal(samples.motion.heading[k, :, 0], scene.vehicles.heading)
            np.testing.assert_allclose(samples.motion.speed[k, :, 0], scene.vehicles.speed, atol=1e-4)


def test_goals_and_their_probabilities_are_recorded_together(generator: Generator, made: list[Samples]) -> None:
    for samples in made:
        if generator.about.goals is None:
            assert (samples.goal == NO_GOAL).all()
            assert np.isnan(samples.natural).all()
        else:
            assert (samples.goal >= 0).all()
            assert ((samples.natural >= 0) & (samples.natural <= 1)).all()
            assert ((samples.used > 0) & (samples.used <= 1)).all()
            assert (samples.attempts >= 1).all()


def test_the_same_seed_gives_the_same_futures(generator: Generator, scenes: list[Scenario], made: list[Samples]) -> None:
    for one, other in zip(made, generator.generate(scenes, SAMPLES, 7), strict=True):
        assert_same(one, other)


def test_a_scenario_gets_the_same_futures_alone_and_in_a_batch(
    generator: Generator, scenes: list[Scenario], made: list[Samples]
) -> None:
    assert_same(generator.generate(scenes[1:2], SAMPLES, 7)[0], made[1])


def test_another_seed_gives_other_futures_where_anything_is_drawn(
    generator: Generator, scenes: list[Scenario], made: list[Samples]
) -> None:
    other = generator.generate(scenes, SAMPLES, 8)
    differs = any((a.motion.position != b.motion.position).any() for a, b in zip(made, other, strict=True))
    draws = generator.about.goals is not None or isinstance(generator, Learned) or generator.backend == "chance"
    assert differs == draws


def test_only_those_who_say_so_look_at_the_log(generator: Generator, scenes: list[Scenario], made: list[Samples]) -> None:
    blind = [replace(s, log=None) for s in scenes]
    if generator.about.kind == BOUND:
        with pytest.raises(UnusableInput):
            generator.generate(blind, SAMPLES, 7)
        return
    log = scenes[0].log
    assert log is not None
    turned = replace(scenes[0], log=replace(log, position=-log.position))
    for one, other in zip(made, generator.generate([turned, *blind[1:]], SAMPLES, 7), strict=True):
        assert_same(one, other)


@pytest.mark.parametrize("name", NAMES)
def test_what_needs_models_names_the_remedy_where_there_are_none(name: str, settings: Settings, tmp_path: Path) -> None:
    plugin = plugins.load("generators", name)
    assert (plugin.about.trains_on == LOGS) == (plugin.about.goals is not None or learns(name))
    if plugin.about.trains_on == NOTHING:
        assert plugin(tmp_path, settings).backend
    else:
        with pytest.raises(MissingTool, match="make run"):
            plugin(tmp_path, settings)


def test_the_log_row_is_the_log(models: Path, settings: Settings, scenes: list[Scenario]) -> None:
    samples = plugins.load("generators", "log")(models, settings).generate(scenes[:1], SAMPLES, 7)[0]
    log = scenes[0].log
    assert log is not None
    for k in range(SAMPLES):
        np.testing.assert_array_equal(samples.motion.position[k], log.position)


@pytest.mark.parametrize("name", [name for name in NAMES if learns(name) and plugins.load("generators", name).name == name])
def test_what_was_saved_and_opened_generates_the_same(name: str, rivals: Callable[[str], Path], settings: Settings) -> None:
    made = trained(name)[0].generate(three_scenes(), SAMPLES, 7)
    opened = plugins.load("generators", name)(rivals(name), settings)
    assert opened.settings == trained(name)[0].settings
    for one, other in zip(made, opened.generate(three_scenes(), SAMPLES, 7), strict=True):
        assert_same(one, other)


def test_vehicles_never_jump_and_face_where_they_go(generator: Generator, made: list[Samples]) -> None:
    if not isinstance(generator, Learned):
        pytest.skip("learns nothing")
    for samples in made:
        step = np.diff(samples.motion.position, axis=2)
        way = np.hypot(step[..., 0], step[..., 1])
        assert way.max() < 10.0  # 100 m/s
        quick = way > 0.2
        facing = samples.motion.heading[:, :, 1:][quick]
        forward = (step[quick] * np.stack([np.cos(facing), np.sin(facing)], axis=-1)).sum(-1)
        assert (forward > 0.7 * way[quick]).mean() > 0.9  # barely trained, and slow ones may be held askew


@pytest.mark.parametrize("name", [name for name in NAMES if learns(name)])
def test_damaged_and_foreign_weights_are_named(
    name: str, rivals: Callable[[str], Path], settings: Settings, tmp_path: Path
) -> None:
    plugin = plugins.load("generators", name)
    folder = tmp_path / "generators" / plugin.name
    shutil.copytree(rivals(name) / "generators" / plugin.name, folder)
    (folder / "weights.safetensors").write_bytes(b"nonsense")
    with pytest.raises(UnusableInput, match="train it again"):
        plugin(tmp_path, settings)
    (folder / "settings.json").write_text('{"generator": "another", "settings": {}}')
    with pytest.raises(UnusableInput, match="another"):
        plugin(tmp_path, settings)


def test_who_places_vehicles_keeps_the_target_and_overlaps_nobody(generator: Generator, scenes: list[Scenario]) -> None:
    if not isinstance(generator, Learned):
        pytest.skip("places none")
    for placement in generator.placements(scenes, 7).values():
        for scene in scenes:
            found = placement(scene)
            assert 1 <= len(found) <= len(scene.vehicles)
            np.testing.assert_array_equal(found.position[TARGET], scene.vehicles.position[TARGET])
            size = found.size[:, :2]
            hit = boxes_overlap(
                found.position[:, None], found.heading[:, None], size[:, None], found.position, found.heading, size
            )
            assert (hit == np.eye(len(found), dtype=bool)).all()
            np.testing.assert_array_equal(placement(scene).position, found.position)


def test_who_says_that_it_places_vehicles_does() -> None:
    logs = three_scenes()
    learned = [name for name in NAMES if learns(name) and plugins.load("generators", name).name == name]
    ways = {name: set(trained(name)[0].placements(logs, 7)) for name in learned}
    assert {name for name in learned if ways[name]} == {name for name in learned if read_methods()[name].places}
    assert ways["trafficgen"] == {"TrafficGen"}
    assert ways["lctgen"] == {"LCTGen, code of a training log", "LCTGen, code from the log (a bound, no method)"}


@pytest.mark.parametrize("name", [name for name in NAMES if learns(name) and plugins.load("generators", name).name == name])
def test_who_draws_by_a_temperature_keeps_the_best_with_the_weights(name: str, settings: Settings, tmp_path: Path) -> None:
    generator, made = copy.deepcopy(trained(name)[0]), {}

    def rolled(tried: Learned) -> dict[str, float]:
        temperature = float(tried.temperature)
        made[temperature] = tried.generate(three_scenes(), SAMPLES, 7)
        return {"a": temperature, "b": 0.02 / temperature, "c": -9 * temperature}

    found = generator.tune([1.0, 0.15, 0.05], rolled, ["a", "b"])
    if not generator.tempered:
        assert found == made == {}
        return
    assert found == {t: {"a": t, "b": 0.02 / t, "c": -9 * t} for t in (1.0, 0.15, 0.05)}
    assert not same(made[1.0], made[0.05])
    generator.save(tmp_path / "generators" / name)
    opened = plugins.load("generators", name)(tmp_path, settings)
    assert float(opened.temperature) == 0.15
    assert same(opened.generate(three_scenes(), SAMPLES, 7), made[0.15])
    assert {float(bound.temperature) for bound in opened.bounds().values()} <= {0.15}


def test_the_first_temperature_is_kept_where_there_is_nothing_to_choose_by() -> None:
    generator = copy.deepcopy(trained("trafficgen")[0])
    assert float(generator.temperature) == 1
    assert generator.tune([0.7, 0.5], lambda _: {}, ["a"]) == {0.7: {}, 0.5: {}}
    assert float(generator.temperature) == 0.7


@pytest.mark.parametrize("name", ["lctgen", "trafficgen"])
def test_the_weights_whose_roll_outs_are_nearest_are_kept(name: str) -> None:
    """And the generator that is asked for its roll-outs on the way can be rolled out."""
    heads, errors = [], iter((3.0, 1.0, 2.0, 4.0))

    def rolled(made: Learned) -> float:
        made.generate(three_scenes()[:1], 1, 7)
        heads.append(next(iter(made.net.parameters())).clone())
        return next(errors)

    generator, curve = fitted(name, 12, rolled)
    assert [row.error for row in curve] == [3.0, 1.0, 2.0, 4.0]
    assert (next(iter(generator.net.parameters())) == heads[1]).all()
    assert not (heads[1] == heads[2]).all()
