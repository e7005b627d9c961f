"""How drivers are taught: round by round, looked at in validation scenes, killed and taken up again."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import torch

from drivegen.core.seeds import derive
from drivegen.core.settings import Count
from drivegen.drivers.shared.lessons import Grade, Lessons, graded
from drivegen.drivers.shared.policy import Policy
from drivegen.training import checkpoint


@dataclass(frozen=True)
class Course:
    """`rounds` of learning; `grade_every`: rounds between two looks at the validation scenes, and two checkpoints."""

    rounds: Count
    grade_every: Count


class Pupil(Protocol):
    """A driver that learns from its lessons.

    Attributes:
        policy: learned so far. tries: what the next round changes, of which `policy` is the running average, or itself.
        parts: everything that the next round depends on, apart from its number and seed.
    """

    policy: Policy
    tries: Policy

    @property
    def parts(self) -> Mapping[str, checkpoint.Part]:
        """See the class."""

    def begin(self, seed: int) -> None:
        """What comes before the first round."""

    def study(self, number: int, seed: int) -> None:
        """Round `number`, the first is 1; all that is random in it comes from `seed`."""


@runtime_checkable
class Taught(Protocol):
    """A driver that can be taught; `lessons_type()` is the dataclass that says how, its attribute `course` for how long."""

    @classmethod
    def lessons_type(cls) -> type:
        """The type of the first argument of `pupil`."""

    @classmethod
    def pupil(cls, how: Any, lessons: Lessons, seed: int) -> Pupil:
        """One that knows nothing yet."""


def teach(
    pupil: Pupil, course: Course, validation: Lessons, seed: int, path: Path | None, say: Callable[[str], None]
) -> tuple[Policy, list[Grade]]:
    """The policy that drives best in `validation` (of those after the first round), and how each drove there.

    With `path` progress is kept there and taken up from there; the file is left to the caller to remove. Same input, same bytes
    on one machine, wherever a training was interrupted.
    """
    torch.set_num_threads(1)  # sums depend on the thread count
    best, logged = copy.deepcopy(pupil.policy), validation.demonstrations()
    parts = {**pupil.parts, "kept": best}
    state = checkpoint.read(path, parts) if path else None
    if state is None:
        pupil.begin(derive(seed, "begin"))
        grades = [graded(0, pupil.policy, validation, logged)]
    else:
        grades = [Grade(**row) for row in state["grades"]]
        say(f"going on after round {grades[-1].round}")
    for number in range(grades[-1].round + 1, course.rounds + 1):
        pupil.study(number, derive(seed, "round", number))
        if number % course.grade_every and number != course.rounds:
            continue
        grades.append(graded(number, pupil.policy, validation, logged))
        say(f"round {number}/{course.rounds}: collisions in {grades[-1].collision:.1%} of validation scenes")
        if grades[-1].badness <= min(grade.badness for grade in grades[1:]):
            best.load_state_dict(pupil.policy.state_dict())
        if path:
            checkpoint.write(path, parts, {"grades": [asdict(grade) for grade in grades]})
    return best, grades
