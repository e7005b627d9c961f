"""Who is best in what on a data set: DriveGen beside the best of the others in every measure, so that losses stand as wins do."""

from collections.abc import Mapping

import numpy as np

from drivegen.metrics.intervals import Interval
from drivegen.metrics.pooled import Resampling, pooled_mean
from drivegen.report.published import METHODS, DataSet, Pooled, resampling_of
from drivegen.report.sections.trust import DISTANCES, JOINT, REALISM, SCORES, horizon_words, is_likelihood
from drivegen.report.table import Cell, Row, Table, row

OURS = "drivegen"
_BOUNDS = ("log", "random_agent")
"""Perfect by definition, and no traffic."""

_ERRORS = {"min_sade": "min-sADE [m]", "min_sfde": "min-sFDE [m]", "mean_sade": "mean-sADE [m]", "mean_sfde": "mean-sFDE [m]"}
_SAFETY = {
    "collision_per_vehicle": "in collision",
    "off_road_per_vehicle": "off road",
    "illegal_per_vehicle": "any violation",
    "joint.collision": "touching another box",
}
_AIMS = {"diversity": 1.0, "auc": 0.5}
"""Measures that are best at a number, and not at either end."""


def best(data: DataSet, pooled: Pooled, draws: int, rng: np.random.Generator) -> Table:
    """One row a measure that DriveGen and another method have; what every scene has is compared pair by pair."""
    resampling = resampling_of(data, draws, rng)
    verdicts: dict[str, int] = {}
    lines = []
    for metric, words in _measures(pooled).items():
        others = {m: pooled[m][metric] for m in METHODS if _compared(m, metric, pooled)}
        if others and metric in pooled.get(OURS, {}):
            line, verdict = _line(data, pooled[OURS][metric], others, metric, words, resampling)
            lines.append(line)
            verdicts[verdict] = verdicts.get(verdict, 0) + 1
    heads = ("", "DriveGen", "the best of the others", "its figure", "DriveGen less it, paired", "DriveGen is")
    counted = ", ".join(f"{verdict} {count}" for verdict, count in sorted(verdicts.items()))
    notes = (
        f"Of {len(lines)} measures: {counted}. Better and worse: zero is outside the 95 % interval of the paired difference; "
        "ahead and behind: it is inside, or measures of the whole set have no pairs and only their figures are compared.",
        "All other methods compete but the log and the random agent, DriveGen without goal selection among them: the best of "
        "several is chosen measure by measure, so it is no one method, and the comparison is hard on DriveGen.",
        data.over,
        "Measures overlap (the four errors, the eight likelihoods): their number says nothing by itself.",
    )
    return Table(f"best-{data.name}", f"Who is best in what: {data.title}", heads, tuple(lines), notes)


def _measures(pooled: Pooled) -> dict[str, str]:
    """All measures that say how well a method did, in words; what only describes (close calls, encounters) is left out."""
    likelihoods = sorted({name for metrics in pooled.values() for name in metrics if is_likelihood(name)})
    realism = {name: f"realism: {words}" for name, words in REALISM.items()}
    distances = {name: f"distance: {words}" for name, words in DISTANCES.items() if name not in _AIMS}
    scores = {name: words.removesuffix(" \u2193") for name, words in SCORES.items()}
    scores |= {name: horizon_words(name).removesuffix(" \u2193") for name in likelihoods}
    scores |= {"energy_final": "energy score at the end [m]", "energy_joint": "energy score of the scene [m]"}
    scores |= {"energy_joint_final": "energy score of the scene, at the end [m]"}
    order = {"joint.order": JOINT["joint.order"].removesuffix(" \u2191")}
    aims = {"diversity": "diversity (best at 1)", "auc": "AUC of a classifier (best at 0.5)"}
    return {**_ERRORS, **aims, **_SAFETY, **order, **realism, **scores, **distances}


def _compared(method: str, metric: str, pooled: Pooled) -> bool:
    known = metric in pooled.get(method, {}) and np.isfinite(pooled[method][metric].value)
    return known and method not in (OURS, *_BOUNDS)


def _badness(metric: str, value: float) -> float:
    if metric in _AIMS:
        return abs(value - _AIMS[metric])
    return -value if metric.startswith("realism") or metric == "joint.order" else value


def _line(
    data: DataSet, mine: Interval, others: Mapping[str, Interval], metric: str, words: str, resampling: Resampling
) -> tuple[Row, str]:
    rival = min(others, key=lambda method: _badness(metric, others[method].value))
    gain = _badness(metric, others[rival].value) - _badness(metric, mine.value)
    values = [data.methods[method].values.get(metric) for method in (OURS, rival)]
    if values[0] is None or values[1] is None:
        difference, verdict = Cell("not paired"), "ahead" if gain > 0 else "level" if gain == 0 else "behind"
    else:
        found = pooled_mean(values[0] - values[1], resampling)
        note = f"{found.low:.3f} to {found.high:.3f}" if np.isfinite(found.low) else ""
        difference = Cell(f"{found.value:+.3f}", note)
        verdict = _verdict(found, gain)
    name = METHODS[rival]
    figures = (f"{mine.value:.3f}", name, f"{others[rival].value:.3f}")
    return row(Cell(words), *figures, difference, Cell(verdict, best=verdict == "better"), origin="ours"), verdict


def _verdict(difference: Interval, gain: float) -> str:
    """In words; `gain` is above zero where DriveGen's figure is the better one."""
    if gain == 0:
        return "level"
    if difference.low > 0 or difference.high < 0:
        return "better" if gain > 0 else "worse"
    return "ahead" if gain > 0 else "behind"
