"""A vision-language model chooses the goals of social vehicles for corner cases (paper, "Corner Case Generation").

It is told what made the driver fail before, in numbers and in pictures, and ranks the places at which each social vehicle would
most likely make it fail again. What it is not asked, or does not answer, keeps the statistical re-weighting (`pressure.py`).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import TARGET
from drivegen.corner_cases.knowledge import Knowledge
from drivegen.corner_cases.pressure import bounded
from drivegen.lm.model import LanguageModel
from drivegen.lm.prompt import Image, fenced
from drivegen.questions.account import Account
from drivegen.questions.asking import Asking, Scene, Settings
from drivegen.questions.goals import Wording
from drivegen.questions.goals_1 import THE_PICTURE, every, shown
from drivegen.rollout.choices import Choices

_INSTRUCTIONS = """\
You test the driving algorithm of the target vehicle. For another vehicle of the same scene you get a picture from above and a
table of numbered places where it may be at the end of the time that is given; every place can be reached by ordinary driving.
Rank the places whose way there would most likely make the target's algorithm fail, the most dangerous first, as many as you are
asked for, each with a reason of at most twenty words. Think of where the target is going, of when the two would meet and how,
and of what the algorithm failed at before, which you are told: features of its earlier collisions, with the share of encounters
that ended in one, and pictures of some.
"""

WORDING = Wording(
    "corner-1",
    _INSTRUCTIONS + THE_PICTURE,
    "Where should it be in {seconds:.0f} seconds to endanger the target?",
    "most dangerous",
    every,
    shown,
)
"""Where vehicles would endanger the target."""

FORECAST_SCENES = 3
"""Scenes whose questions are really made for the forecast of what calls will cost."""


def asking(
    model: LanguageModel,
    settings: Settings,
    seed: int,
    knowledge: Knowledge,
    pictures: tuple[str | Image, ...],
    reaction_time: float,
) -> Asking:
    """Who asks about social vehicles, with what is known and pictures of earlier collisions before every question."""
    early = f"A meeting in the first {reaction_time:g} s leaves the target no time to react: it shows nothing."
    more = (settings.knowledge,) if settings.knowledge else ()
    facts = fenced("knowledge", "\n".join([in_words(knowledge), early, *more]))
    return Asking(model, settings, seed, (facts, *pictures), WORDING, spared=frozenset({TARGET}))


def in_words(knowledge: Knowledge) -> str:
    """What encounters have in common that ended in a collision, riskiest first: shares with their 95 % intervals."""
    lines = [
        f"The target's algorithm met others {int(knowledge.encounters.sum())} times and collided "
        f"{int(knowledge.collisions.sum())} times (share {knowledge.base_rate:.3f}).",
        "Feature of the other vehicle as they met: share of such encounters that ended so [95 % interval], encounters.",
    ]
    for row in knowledge.rows():
        interval = f"[{row['low']:.3f}, {row['high']:.3f}]"
        value = str(row["value"]).replace("_", " ")
        lines.append(f"{row['feature']}: {value}: {row['probability']:.3f} {interval}, {row['encounters']}")
    return "\n".join(lines)


def scene_of(choice: Choices, leaning: Choices) -> Scene:
    """What is asked about one scenario, `leaning` being its choices under the statistical re-weighting."""
    return Scene(choice.scenario, choice.candidates, leaning.used)


def forecast(asking: Asking, choices: Sequence[Choices], scenarios: int) -> str:
    """What the calls about so many `scenarios` will cost, from the questions about the first FORECAST_SCENES of `choices`."""
    first = choices[:FORECAST_SCENES]
    return asking.model.forecast(*asking.questions([scene_of(choice, choice) for choice in first]), scenarios / len(first))


def endanger(
    choices: Sequence[Choices], leaning: Sequence[Choices], asker: Asking, max_ratio: float, account: Account
) -> list[Choices]:
    """Choices whose `used` follow the model's ranking, those of `leaning` where it gave none.

    As under the re-weighting, no ratio to the probabilities without pressure exceeds `max_ratio`, nor its inverse.
    Raises MissingTool where a recorded answer is missing and nobody may be asked, OverBudget.
    """
    asker.ahead([scene_of(*pair) for pair in zip(choices, leaning, strict=True)])
    return [_one(choice, lean, asker, max_ratio, account) for choice, lean in zip(choices, leaning, strict=True)]


def _one(choice: Choices, leaning: Choices, asker: Asking, max_ratio: float, account: Account) -> Choices:
    odds_of_model = asker.odds(scene_of(choice, leaning), account)
    return replace(
        choice,
        used=[
            odds if odds is lean else _within(used, odds, max_ratio)
            for used, odds, lean in zip(choice.used, odds_of_model, leaning.used, strict=True)
        ],
    )


def _within(used: NDArray[np.floating], odds: NDArray[np.floating], max_ratio: float) -> NDArray[np.float32]:
    """`odds` (C,) with its ratio to `used` bounded; what is never drawn stays so."""
    possible = used > 0
    tilt = np.zeros(len(used))
    tilt[possible] = odds[possible].astype(np.float64) / used[possible]
    return bounded(used, np.maximum(tilt / tilt.max(), 1e-9), max_ratio)
