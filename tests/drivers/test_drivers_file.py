"""A driver that is a file of somebody's own: it drives, or one sentence says why it cannot."""

from pathlib import Path

import numpy as np
import pytest
import torch

from drivegen.core.errors import UnusableInput
from drivegen.core.settings import read_params
from drivegen.drivers.shared.file import FileDriver
from drivegen.simulators.batch import Plugin as Batch
from drivegen.world.observation import Action
from drivegen.world.outcome import CollisionKind
from drivegen.world.reactive import Reaction
from tests.scenes import drive, scenario, stack, straight_road

GOOD = "from drivegen.world.observation import Action\ndef act(seen): return Action(0 * seen.speed)\n"
BAD = {
    "no_function": ("x = 1\n", "has no function act.observation.: see docs/drivers.md"),
    "plugin": (
        "class Plugin:\n    pass\n",
        "no function act.observation.: its `Plugin` needs settings, which params.yaml has by name;",
    ),
    "does_not_run": ("import nothing_like_it\n", "cannot be run: ModuleNotFoundError"),
    "no_python": ("def act(:\n", "cannot be run: SyntaxError"),
    "raises": (
        "def helper(seen):\n    return seen.nothing\ndef act(seen): return helper(seen)\n",
        "fails in line 2: AttributeError",
    ),
    "exits": ("import sys\ndef act(seen): sys.exit(0)\n", "fails in line 2: SystemExit"),
    "exits_at_once": ("raise SystemExit(0)\n", "cannot be run: SystemExit"),
    "no_action": ("def act(seen): return -1.0\n", "must return"),
    "too_few": (GOOD.replace("0 * seen.speed", "seen.speed[:1]"), "each of the 512 targets"),
    "no_number": (GOOD.replace("0 *", "float('nan') *"), "acceleration that is no number"),
    "complex": (GOOD.replace("0 *", "1j *"), "one real number"),
    "too_large": (GOOD.replace("0 * seen.speed", "1e300 * seen.speed.double()"), "acceleration that is no number"),
    "numpy": (GOOD.replace("seen.speed)", "seen.speed.numpy())"), "as acceleration a PyTorch tensor"),
    "numpy_offset": (GOOD.replace("seen.speed)", "seen.speed, seen.speed.numpy())"), "as offset a PyTorch tensor"),
    "steers": (GOOD.replace("seen.speed)", "seen.speed, steering=seen.speed)"), "drivers keep to paths"),
    "no_offset": (GOOD.replace("seen.speed)", "seen.speed, seen.speed * float('nan'))"), "offset that is no number"),
}
ROAD = straight_road(600)
LINE = ROAD.centreline[0].astype(float)
LOG = stack([drive(LINE, 20, 12, 101), drive(LINE, 80, 0, 101)])
DATACLASS = "from __future__ import annotations\nfrom dataclasses import dataclass\n@dataclass\nclass Mine:\n    x: float = 0.0\n"


def outcome(tmp_path, text, name="mine.py"):
    file = tmp_path / name
    file.write_text(text)
    return Batch().run(FileDriver(file), [scenario(ROAD, LOG)], [LOG])


def test_it_drives(tmp_path):
    assert np.array_equal(outcome(tmp_path, GOOD).kind, [CollisionKind.FRONT])


def test_its_file_may_have_dataclasses_with_annotations_as_text(tmp_path):
    assert len(outcome(tmp_path, DATACLASS + GOOD).kind) == 1


def test_numbers_of_another_kind_are_taken_as_the_world_s(tmp_path):
    text = GOOD.replace("0 * seen.speed", "0 * seen.speed.double()")
    file = tmp_path / "mine.py"
    file.write_text(text)
    world = Batch(reaction=read_params("drive.reaction", Reaction))
    assert np.array_equal(world.run(FileDriver(file), [scenario(ROAD, LOG)], [LOG]).kind, outcome(tmp_path, GOOD).kind)


def test_what_it_changes_of_what_it_sees_changes_nothing(tmp_path):
    spoilt = GOOD.replace("return", "seen.speed.clamp_min_(30.0); seen.along.add_(50.0); seen.paths.length.zero_(); return")
    untouched, touched = (outcome(tmp_path, text).motion for text in (GOOD, spoilt))
    assert np.array_equal(untouched.position, touched.position)


class Plain:
    """A driver of the folder, whose code sees the world's own tensors: `answer` of the observation."""

    name = "plain"

    def __init__(self, answer):
        self.act = answer


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        (lambda seen: Action(seen.speed * float("nan")), "driver plain: .*an acceleration that is no number"),
        (lambda seen: Action(seen.speed[:, None]), "driver plain: .*one real number for each of the 512 targets"),
        (lambda seen: Action(seen.speed.numpy()), "driver plain: .*a PyTorch tensor"),
        (lambda seen: seen.speed, "driver plain: .*not Tensor"),
    ],
)
def test_what_a_driver_of_the_folder_answers_is_checked_too(answer, why):
    with pytest.raises(UnusableInput, match=why):
        Batch().run(Plain(answer), [scenario(ROAD, LOG)], [LOG])


def test_no_driver_stops_itself_by_changing_what_it_sees():
    def cheat(seen):
        for own in (seen.speed, seen.along, seen.offset, seen.course):
            own.zero_()
        return Action(torch.zeros(len(seen.speed)))

    same, cheated = (
        Batch().run(Plain(act), [scenario(ROAD, LOG)], [LOG]).motion
        for act in (lambda seen: Action(torch.zeros_like(seen.speed)), cheat)
    )
    assert np.array_equal(same.position, cheated.position)


def test_no_driver_brakes_or_starts_harder_than_a_car_can(tmp_path):
    for asked, hardest in (("1e6", 4.0), ("-1e6", -9.0)):
        speed = outcome(tmp_path, GOOD.replace("0 * seen.speed", f"0 * seen.speed + {asked}")).motion.speed[0]
        assert float(speed[1] - speed[0]) == pytest.approx(0.1 * hardest, abs=1e-4)


def test_without_an_offset_it_goes_back_to_its_path_s_line(tmp_path):
    swerve = GOOD.replace("0 * seen.speed)", "0 * seen.speed, OFFSET)")
    texts = (
        swerve.replace("OFFSET", f"1.5 + 0 * seen.speed if seen.step[0] < 5 else {back}") for back in ("None", "0 * seen.speed")
    )
    none, zero = (outcome(tmp_path, text).motion for text in texts)
    assert np.array_equal(none.position, zero.position)
    assert np.abs(none.position[0, 4:6, 1]).max() > 0.5
    assert float(np.abs(none.position[0, 30, 1])) == pytest.approx(0, abs=1e-3)


def test_it_sees_rules(tmp_path):
    assert len(outcome(tmp_path, GOOD.replace("0 * seen.speed", "0 * seen.rules.distance.clamp_max(1)")).kind) == 1


@pytest.mark.parametrize("name", BAD)
def test_one_that_cannot_be_run_gives_one_sentence(name, tmp_path):
    text, why = BAD[name]
    with pytest.raises(UnusableInput, match=why) as raised:
        outcome(tmp_path, text)
    assert str(tmp_path / "mine.py") in str(raised.value)
    assert "\n" not in str(raised.value)


def test_the_line_is_named_whatever_leads_to_the_file(tmp_path, monkeypatch):
    file = tmp_path / "mine.py"
    file.write_text(BAD["raises"][0])
    (tmp_path / "link.py").symlink_to(file)
    monkeypatch.chdir(tmp_path)
    for path in ("mine.py", "link.py", f"../{tmp_path.name}/mine.py"):
        with pytest.raises(UnusableInput, match=f"^{path}: .* fails in line 2: AttributeError"):
            Batch().run(FileDriver(Path(path)), [scenario(ROAD, LOG)], [LOG])


def test_a_file_that_is_not_there_or_no_python_is_named(tmp_path):
    for name in ("nowhere.py", "mine.txt"):
        with pytest.raises(UnusableInput, match=name):
            FileDriver(tmp_path / name)
