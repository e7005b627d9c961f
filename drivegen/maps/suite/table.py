"""Trials counted, per suite and kind: the table that says how often a map from words is the map that was asked for."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from drivegen.maps.suite.trials import Trial

STEPS = ("understood", "valid_xml", "accepted", "loads", "as_asked")
"""What a description goes through on its way to a road, in order."""

ROUNDS = 3
"""Rounds of repair at most."""


def counted(trials: Sequence[Trial]) -> dict[str, Any]:
    """Counts of a group: descriptions to draw and how far they came, those to refuse, and the share that came out right."""
    roads = [trial for trial in trials if trial.case.expect is not None]
    repaired = Counter(trial.repairs for trial in roads if trial.right)
    return {
        "roads": len(roads),
        **{step: sum(getattr(trial, step) for trial in roads) for step in STEPS},
        **{f"repaired_after_{k}": repaired[k] for k in range(1, ROUNDS + 1)},
        "declined": sum(bool(trial.refused) for trial in roads),
        "stood_in_for": sum(bool(trial.stood_in) for trial in roads),
        "to_refuse": len(trials) - len(roads),
        "refused": sum(trial.right for trial in trials) - sum(trial.right for trial in roads),
        "right": sum(trial.right for trial in trials),
        "share_right": round(sum(trial.right for trial in trials) / max(1, len(trials)), 4),
    }


def published(written_by: str, trials: Sequence[Trial]) -> dict[str, Any]:
    """All that is told of one writer; the same trials give the same values, so no times are in it."""
    return {
        "written_by": written_by,
        "measured": True,
        "suites": by_suite(trials),
        "kinds": by_kind(trials),
        "failed": failed(trials),
    }


def not_measured(written_by: str) -> dict[str, Any]:
    """The same of a writer that nobody has run."""
    return {"written_by": written_by, "measured": False}


def by_suite(trials: Sequence[Trial]) -> dict[str, dict[str, Any]]:
    """Counts of every suite."""
    groups = {suite: [t for t in trials if t.case.suite == suite] for suite in dict.fromkeys(t.case.suite for t in trials)}
    return {name: counted(group) for name, group in groups.items()}


def by_kind(trials: Sequence[Trial]) -> dict[str, dict[str, Any]]:
    """Counts of every kind, of all suites together."""
    kinds = sorted({trial.case.kind for trial in trials})
    return {kind: counted([trial for trial in trials if trial.case.kind == kind]) for kind in kinds}


def seconds(trials: Sequence[Trial]) -> dict[str, float]:
    """Mean processor time of a description by suite and by kind [s]; it differs from run to run."""
    names = {name for trial in trials for name in (trial.case.suite, trial.case.kind)}
    groups = {name: [t.seconds for t in trials if name in (t.case.suite, t.case.kind)] for name in names}
    return {name: sum(taken) / len(taken) for name, taken in groups.items()}


def failed(trials: Sequence[Trial]) -> list[dict[str, Any]]:
    """What did not come out right, and why."""
    return [
        {"suite": t.case.suite, "text": t.case.text[:120], "refused": t.refused[:120], "wrong": [w[:160] for w in t.wrong[:4]]}
        for t in trials
        if not t.right
    ]
