"""What means and intervals are taken over, in the words that stand under a table."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from drivegen.core.scenario import DT

FEW, TOO_FEW = 20, 5
"""Of fewer recordings intervals are called too narrow, and of fewer than the second they tell nothing apart."""

HELD = {2: 50, 3: 73, 5: 82, 10: 89, 14: 92, 40: 93}
"""In how many of 100 cases a 95 % interval over so many recordings holds the true mean, for normal figures (`core.intervals`)."""


def taken_over(methods: Mapping[str, Mapping[str, Any]]) -> tuple[str, ...]:
    """The note for the details of an evaluation, which are of the same scenes for all methods; none where they don't say."""
    details = next((values for values in methods.values() if "recordings" in values), None)
    if details is None:
        return ()
    others = {int(key.removeprefix("left_out.")): count for key, count in details.items() if key.startswith("left_out.")}
    return (scenes_and_recordings(details["scenarios"], details["recordings"], details["steps"], others),)


def scenes_and_recordings(scenes: int, recordings: int, steps: int | None, others: Mapping[int, int]) -> str:
    """The note for `scenes` scenes of `steps` steps (None if unknown).

    `others` are numbers of scenes by another number of steps, which are left out.
    """
    several = f"intervals (95 %) over their {recordings} recordings{_narrow(recordings)}"
    sentence = f"Means are over {scenes} scenes{'' if steps is None else f' of {seconds(steps)} s'}, "
    sentence += f"{several}." if recordings > 1 else "all of one recording, which gives no intervals."
    if not others:
        return sentence
    left_out = " and ".join(f"{count} of {seconds(length)} s" for length, count in sorted(others.items()))
    return f"{sentence} Scenes of another length are not averaged with them: {left_out}."


def vehicles_over(group: Mapping[str, Any]) -> tuple[str, ...]:
    """The note for the scores of goals, those of one group of vehicles; none where they don't say."""
    if "recordings" not in group:
        return ()
    sentence, others = over_recordings(int(group["recordings"])), int(group["left_out"])
    return (f"{sentence} Vehicles of scenes of another length are not averaged with these: {others}." if others else sentence,)


def over_recordings(count: int) -> str:
    """The note on intervals alone."""
    return f"Intervals (95 %) are over {count} recordings{_narrow(count)}." if count > 1 else "One recording gives no intervals."


def _narrow(recordings: int) -> str:
    """A word of caution on percentile intervals of few recordings."""
    if recordings >= FEW:
        return ""
    held = np.interp(recordings, list(HELD), list(HELD.values()))
    return f", which are few: they hold less than 95 %, about {held:.0f} %"


def seconds(steps: int) -> str:
    """What `steps` steps last, the first being at 0 s."""
    return f"{(steps - 1) * DT:g}"
