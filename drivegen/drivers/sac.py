"""SAC: drives for a reward (Haarnoja et al. 2018), by Stable-Baselines3 in the batched world.

Nobody shows it how to drive: it goes where progress, comfort, limits, lights and collisions, as `train_driver.drivers.sac` in
params.yaml weighs them, add up to most. Stable-Baselines3 is needed to learn, not to drive.
"""

from dataclasses import dataclass

from drivegen.core.errors import UnusableInput
from drivegen.core.settings import Count, Positive, Share
from drivegen.drivers.shared import conditions
from drivegen.drivers.shared.lessons import Lessons
from drivegen.drivers.shared.network import Network
from drivegen.drivers.shared.teaching import Course, Pupil


@dataclass(frozen=True)
class Teaching:
    """How it learns.

    Attributes:
        rows: episodes side by side. steps: of each in a round, which begins with new episodes. updates: after each step of
            all rows. batch, learning_rate: of an update. discount: gamma. rewards: steps whose rewards stand before what
            is expected afterwards. pull: tau, share of the critics in the average that says what is expected, an update. entropy:
            the weight that it begins with.
    """

    course: Course
    environment: conditions.Settings
    rows: Count
    steps: Count
    updates: Count
    batch: Count
    learning_rate: Positive
    discount: Share
    rewards: Count
    pull: Share
    entropy: Positive

    def __post_init__(self) -> None:
        if self.environment.motion != "path":
            raise UnusableInput(
                f"train_driver.drivers.sac.environment.motion must be path, not {self.environment.motion!r}: the policy says"
                " an acceleration alone"
            )


class Plugin(Network):
    """The policy as a driver."""

    name = "sac"

    @classmethod
    def lessons_type(cls) -> type:
        """See `teaching.Taught`."""
        return Teaching

    @classmethod
    def pupil(cls, how: Teaching, lessons: Lessons, seed: int) -> Pupil:
        """See `teaching.Taught`."""
        from drivegen.drivers._sac.pupil import Learner  # not at the top: who drives needs no Stable-Baselines3

        return Learner(how, lessons, seed)
