"""Trials counted, per suite and group: right at once, right after the offered sentence, declined, wrong."""

from collections.abc import Sequence
from typing import Any

from drivegen.maps.suite.trials import Trial

COUNTS = ("lines", "right", "right_after_offer", "declined", "wrong")
"""`declined` are those of which something could be drawn; of a group to be refused, `right` are those that were."""


def counted(trials: Sequence[Trial]) -> dict[str, Any]:
    """Counts of a group of trials."""
    return {
        "lines": len(trials),
        "right": sum(trial.right for trial in trials),
        "right_after_offer": sum(trial.right_after_offer for trial in trials),
        "declined": sum(bool(trial.refused) and not trial.right for trial in trials),
        "wrong": sum(trial.is_wrong for trial in trials),
        "repaired": sum(trial.repairs > 0 and trial.right for trial in trials),
    }


def published(written_by: str, trials: Sequence[Trial]) -> dict[str, Any]:
    """All that is told of one writer; the same trials give the same values, so no times are in it."""
    return {"written_by": written_by, "measured": True, "groups": by_group(trials), "failed": failed(trials)}


def not_measured(written_by: str) -> dict[str, Any]:
    """The same of a writer that nobody has run."""
    return {"written_by": written_by, "measured": False}


def group_of(trial: Trial) -> str:
    """The name of a trial's group."""
    return f"{trial.case.suite}, {trial.case.group}"


def by_group(trials: Sequence[Trial]) -> dict[str, dict[str, Any]]:
    """Counts of every group of every suite."""
    names = dict.fromkeys(group_of(trial) for trial in trials)
    return {name: counted([trial for trial in trials if group_of(trial) == name]) for name in names}


def seconds(trials: Sequence[Trial]) -> dict[str, float]:
    """Mean processor time of a description by group [s]; it differs from run to run."""
    groups = {name: [t.seconds for t in trials if group_of(t) == name] for name in {group_of(t) for t in trials}}
    return {name: sum(taken) / len(taken) for name, taken in groups.items()}


def failed(trials: Sequence[Trial]) -> list[dict[str, Any]]:
    """What did not come out right, and why."""
    return [
        {
            "group": group_of(t),
            "text": t.case.text[:160],
            "refused": t.refused.partition("\n")[0][:160],
            "offer": t.offer[:300],
            "wrong": [w[:160] for w in (t.wrong or t.offer_wrong or ())[:4]],
        }
        for t in trials
        if not t.right
    ]
