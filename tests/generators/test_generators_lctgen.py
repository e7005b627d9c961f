"""LCTGen's codes by hand, its bound that knows the log, retrieval of maps, words."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import boxes_overlap
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.generators._lctgen.codes import PARTS, Action, Direction, logged_actions, state_code
from drivegen.generators._lctgen.learning import NO_PIECE, Taught, places
from drivegen.generators._lctgen.net import ContextGating
from drivegen.generators.lctgen import CHUNK, Plugin
from drivegen.generators.shared.vectors import AGENTS, Scenes
from tests.generators.rivals import same, scenes, trained
from tests.scenes import busy_crossing, drive, scenario, stack, straight_road


def one(track: Trajectories) -> Scenario:
    return scenario(straight_road(600), stack([track]))


def with_speed(speeds: np.ndarray) -> Trajectories:
    """Along y = 0 with the given speed (101,) at each step."""
    made = Trajectories.empty(101)
    made.position[:, 0] = 20 + np.concatenate([[0], np.cumsum(speeds[1:]) * 0.1])
    made.velocity[:, 0] = speeds
    made.valid[:] = True
    return made


def test_gating_heeds_only_who_is_there_and_means_over_blocks() -> None:
    torch.manual_seed(7)
    gating, x = ContextGating(4, 2), torch.randn(1, 3, 4)
    there = torch.tensor([[True, True, False]])
    changed = torch.cat([x[:, :2], x[:, 2:] + 5], dim=1)
    (elements, context), (others, same_context) = gating(x, there), gating(changed, there)
    assert torch.equal(context, same_context)
    assert torch.equal(elements[:, :2], others[:, :2])
    first = gating.elements[0](x) * gating.contexts[0](gating.first)
    middle, seen = x + (first - x) / 2, gating.first + (first[:, :2].amax(1) - gating.first) / 2
    second = gating.elements[1](middle) * gating.contexts[1](seen)[:, None]
    assert torch.allclose(elements, middle + (second - middle) / 3)
    assert torch.allclose(context, seen + (second[:, :2].amax(1) - seen) / 3)


def test_states_are_coded_as_seen_from_the_target() -> None:
    line = straight_road().centreline[0].astype(np.float64)
    other = straight_road().centreline[1].astype(np.float64)
    cars = [drive(line, 100, 8, 11), drive(line, 78, 3, 11), drive(other[::-1], 150, 11, 11)]
    code = state_code(Scenes.of([scenario(straight_road(), stack(cars))]))[0, :3]
    assert code[0].tolist() == [0, 0, Direction.SAME, 3]
    assert code[1, 1:].tolist() == [4, Direction.SAME, 1]
    assert code[1, 0] in (1, 2)
    assert code[2].tolist() == [0, 10, Direction.OPPOSITE, 4]


@pytest.mark.parametrize(
    ("speeds", "actions"),
    [
        (np.full(101, 8.0), [Action.KEEP_SPEED] * 4),
        (np.concatenate([np.linspace(8, 0, 26), np.zeros(75)]), [Action.STOP] * 4),
        (np.concatenate([np.full(26, 10.0), np.linspace(10, 1, 75)]), [Action.KEEP_SPEED] + [Action.SLOW_DOWN] * 3),
        (np.linspace(2, 14, 101), [Action.SPEED_UP] * 4),
    ],
)
def test_actions_of_speed(speeds: np.ndarray, actions: list[Action]) -> None:
    found, seen = logged_actions(Scenes.with_logs([one(with_speed(speeds))]))
    assert seen[0, 0].all()
    assert not seen[0, 1:].any()
    assert found[0, 0].tolist() == actions


@pytest.mark.parametrize(
    ("side", "turn", "change"), [(1, Action.TURN_LEFT, Action.CHANGE_LEFT), (-1, Action.TURN_RIGHT, Action.CHANGE_RIGHT)]
)
def test_actions_to_the_sides(side: int, turn: Action, change: Action) -> None:
    t = np.arange(101) * 0.1
    track = with_speed(np.full(101, 8.0))
    shift = np.clip((t - 2.5) / 2.5, 0, 1)
    track.position[:, 1] = side * 3.5 * shift
    found, _ = logged_actions(Scenes.with_logs([one(track)]))
    assert found[0, 0].tolist() == [Action.KEEP_SPEED, change, Action.KEEP_SPEED, Action.KEEP_SPEED]
    track = with_speed(np.full(101, 8.0))
    track.heading[:] = side * np.clip((t - 5) / 2.5, 0, 1) * 1.5
    found, _ = logged_actions(Scenes.with_logs([one(track)]))
    assert found[0, 0, 2] == turn


def test_what_the_log_did_not_see_is_no_action() -> None:
    track = with_speed(np.full(101, 8.0))
    track.valid[60:] = False
    _, seen = logged_actions(Scenes.with_logs([one(track)]))
    assert seen[0, 0].tolist() == [True, True, False, False]


def test_a_vehicle_stands_on_the_piece_beneath_it() -> None:
    line = straight_road(lanes=1).centreline[0].astype(np.float64)
    scene = scenario(straight_road(lanes=1), stack([drive(line, 100, 8, 11), drive(line[::-1], 100, 8, 11)]))
    scenes_ = Scenes.of([scene])
    piece, attributes = places(scenes_, scenes_)
    middle = scenes_.points[0, piece[0, 0]].mean(axis=0)
    assert np.hypot(*middle) <= 7.6
    np.testing.assert_allclose(attributes[0, 0, 0] * 5, -middle[0], atol=1e-3)
    np.testing.assert_allclose(attributes[0, 0, 3:] * [5, 5, 10], [*scene.vehicles.size[0, :2], 8.0], atol=1e-3)
    assert piece[0, 1] == NO_PIECE  # against the only lane's direction
    assert (piece[0, 2:] == NO_PIECE).all()


def test_losses_of_all_parts_go_down() -> None:
    _, first, last = trained("lctgen")
    assert last < 0.9 * first


class Told(Plugin):
    """LCTGen told that everybody does one thing."""

    action = Action.STOP

    def known_actions(self, scenarios: Sequence[Scenario]) -> np.ndarray:
        return np.full((CHUNK, AGENTS, PARTS), self.action)


def test_actions_matter(tmp_path: Path) -> None:
    trained("lctgen")[0].save(tmp_path / "generators" / "lctgen")
    told = Told(tmp_path, None)
    stopped = told.generate(scenes(), 2, 7)
    told.action = Action.SPEED_UP
    assert not same(stopped, told.generate(scenes(), 2, 7))


def test_without_a_log_the_bound_says_so() -> None:
    scene = replace(busy_crossing(), log=None)
    found, seen = logged_actions(Scenes.with_logs([scene]))
    assert len(found) == len(seen) == 0


@pytest.fixture(scope="module")
def generator() -> Plugin:
    made = trained("lctgen")[0]
    assert isinstance(made, Plugin)
    return made


def test_placed_vehicles_stand_free_of_one_another_behind_the_given_target(generator: Plugin) -> None:
    scene = busy_crossing()
    ahead = [
        (3, 3, 0, 3),
        (3, 4, 0, 5),
        (0, 5, 0, 3),
        (3, 1, 0, 3),
        (3, 5, 0, 4),
        (3, 4, 0, 4),
        (3, 5, 0, 3),
        (0, 4, 0, 2),
        (0, 6, 0, 4),
    ]
    oncoming = [(1, 11, 2, 5), (1, 4, 2, 4)]
    code = np.array([(*state, *[Action.KEEP_SPEED] * 4) for state in ahead + oncoming], np.int64)
    placed = generator.place(scene, code, np.random.default_rng(2))
    placed.validate()
    assert 2 <= len(placed) <= len(code)
    np.testing.assert_array_equal(placed.position[0], scene.vehicles.position[0])
    first, second = np.triu_indices(len(placed), 1)
    size = placed.size[:, :2]
    assert not boxes_overlap(
        placed.position[first], placed.heading[first], size[first], placed.position[second], placed.heading[second], size[second]
    ).any()
    again = generator.place(replace(scene, vehicles=scene.vehicles[:1], log=None), code, np.random.default_rng(2))
    np.testing.assert_array_equal(again.position, placed.position)  # the others of the scenario are not looked at


def test_whoever_is_to_be_placed_chooses_none_of_the_roads_that_it_is_placed_on():
    """The road is 3 km long, so that 256 pieces do not hold it."""
    line = straight_road(3000, 3).centreline[0].astype(np.float64)
    target, far = drive(line, 200, 8, 11), drive(line, 2500, 8, 11)
    alone, both = (Taught.of([scenario(straight_road(3000, 3), stack(cars))]) for cars in ([target], [target, far]))
    for name in ("points", "road", "drawn"):
        np.testing.assert_array_equal(getattr(both, name), getattr(alone, name))
    assert both.piece[0, 0] == alone.piece[0, 0] != NO_PIECE
    assert both.piece[0, 1] == NO_PIECE  # nobody can be placed there
    _, bare, *_ = both.tensors(np.zeros(1, int), torch.device("cpu"))
    assert bare.present.sum() == 2
    np.testing.assert_array_equal(bare.points.numpy(), alone.points)


def test_the_code_that_is_placed_by_says_of_the_target_what_its_first_frame_does(generator: Plugin, monkeypatch):
    given: list[np.ndarray] = []
    monkeypatch.setattr(generator, "place", lambda scenario, code, rng: given.append(code) or scenario.vehicles)
    slow, fast = (scenario(straight_road(), stack([drive(straight_road().centreline[0], 20, v, 101)] * 2)) for v in (3.0, 14.0))
    place = next(iter(generator.placements([slow], 7).values()))
    place(fast)
    place(slow)
    assert [code[:, 3].tolist() for code in given] == [[5, 1], [1, 1]]  # bins of 2.5 m/s


def test_a_code_of_too_many_vehicles_is_named(generator: Plugin) -> None:
    with pytest.raises(UnusableInput, match="16 at most"):
        generator.place(busy_crossing(), np.zeros((17, 8), np.int64), np.random.default_rng(0))
