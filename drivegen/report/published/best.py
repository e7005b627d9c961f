"""Who is best in what on a data set: DriveGen beside the best of the others in every measure, so that losses stand as wins do."""

from collections import Counter
from collections.abc import Mapping

import numpy as np

from drivegen.core.intervals import Interval, recording
from drivegen.metrics.pooled import Resampling, pooled_mean
from drivegen.report.averaged import TOO_FEW
from drivegen.report.columns import AIMS, SAFETY, badness
from drivegen.report.published.results import ADDED, OURS, DataSet, Pooled, resampling_of
from drivegen.report.sections.trust import DISTANCES, JOINT, REALISM, SCORES, horizon_words, is_likelihood
from drivegen.report.table import Cell, Row, Table, decimals, row

_ERRORS = {"min_sade": "min-sADE [m]", "min_sfde": "min-sFDE [m]", "mean_sade": "mean-sADE [m]", "mean_sfde": "mean-sFDE [m]"}


def best(data: DataSet, pooled: Pooled, draws: int, rng: np.random.Generator) -> list[Table]:
    """One row a measure that DriveGen and another method have; what every scene has is compared pair by pair.

    No table where there is no such measure.
    """
    resampling = resampling_of(data, draws, rng)
    lines_of: dict[str, tuple[Row, str]] = {}
    for metric, words in _measures(pooled).items():
        others = {name: pooled[name][metric] for name in _rivals(data) if _known(name, metric, pooled)}
        if others and _known(OURS, metric, pooled):
            lines_of[metric] = _line(data, pooled[OURS][metric], others, metric, words, resampling)
    if not lines_of:
        return []
    lines, verdicts = zip(*lines_of.values(), strict=True)
    heads = ("", "DriveGen", "the best of the others", "its figure", "DriveGen less it, paired", "DriveGen is")
    counted = ", ".join(f"{verdict} {count}" for verdict, count in sorted(Counter(verdicts).items()))
    errors, likelihoods = (sum(map(kind, lines_of)) for kind in (_ERRORS.__contains__, is_likelihood))
    notes = (
        f"Of {len(lines)} measures: {counted}. Better and worse: zero is outside the 95 % interval of the paired difference; "
        "ahead and behind: it is inside, or there is no interval. Measures of the whole set have no pairs: of them only figures "
        "are compared.",
        "All other methods compete but the log and the random agent, DriveGen without goal selection and rivals with its "
        "additions among them: the best of many is chosen measure by measure, so it is no one method, and the comparison is hard "
        "on DriveGen.",
        data.over,
        f"Measures overlap (errors: {errors}, likelihoods: {likelihoods}): their number says nothing by itself.",
    )
    return [Table(f"best-{data.name}", f"Who is best in what: {data.title}", heads, lines, notes)]


def _rivals(data: DataSet) -> list[str]:
    """Whoever competes with DriveGen, then the same with additions."""
    rivals = [name for name, method in data.about.items() if name != OURS and method.competes]
    added = [name for name in data.added if name.partition("/")[0] in rivals and not name.endswith("/none")]
    return [*rivals, *added]


def _measures(pooled: Pooled) -> dict[str, str]:
    """All measures that say how well a method did, in words; what only describes (close calls, encounters) is left out."""
    likelihoods = sorted({name for metrics in pooled.values() for name in metrics if is_likelihood(name)})
    realism = {name: f"realism: {words}" for name, words in REALISM.items()}
    distances = {name: f"distance: {words}" for name, words in DISTANCES.items() if name not in AIMS}
    scores = {name: words.removesuffix(" \u2193") for name, words in SCORES.items()}
    scores |= {name: horizon_words(name).removesuffix(" \u2193") for name in likelihoods}
    scores |= {"energy_final": "energy score at the end [m]", "energy_joint": "energy score of the scene [m]"}
    scores |= {"energy_joint_final": "energy score of the scene, at the end [m]"}
    order = {"joint.order": JOINT["joint.order"].removesuffix(" \u2191")}
    aims = {"diversity": "diversity (best at 1)", "auc": "AUC of a classifier (best at 0.5)"}
    safety = {**SAFETY, "joint.collision": "touching another box"}
    return {**_ERRORS, **aims, **safety, **order, **realism, **scores, **distances}


def _known(method: str, metric: str, pooled: Pooled) -> bool:
    interval = pooled.get(method, {}).get(metric)
    return interval is not None and bool(np.isfinite(interval.value))


def _line(
    data: DataSet, mine: Interval, others: Mapping[str, Interval], metric: str, words: str, resampling: Resampling
) -> tuple[Row, str]:
    rival = min(others, key=lambda method: badness(metric, others[method].value))
    less = _less(data, rival, metric, resampling)
    if less is None:
        gain = badness(metric, others[rival].value) - badness(metric, mine.value)
        difference, verdict = Cell("not paired"), _verdict(gain, significant=False)
    else:
        note = f"{decimals(less.low, 3)} to {decimals(less.high, 3)}" if np.isfinite(less.low) else ""
        difference = Cell(decimals(less.value, 3, "+"), note)
        verdict = _verdict(-badness(metric, less.value), significant=less.low > 0 or less.high < 0)
    method, _, additions = rival.partition("/")
    name = data.about[method].title + (f", {ADDED[additions]}" if additions else "")
    figures = (f"{mine.value:.3f}", name, f"{others[rival].value:.3f}")
    return row(Cell(words), *figures, difference, Cell(verdict, best=verdict == "better"), origin="ours"), verdict


def _less(data: DataSet, rival: str, metric: str, resampling: Resampling) -> Interval | None:
    """DriveGen less the rival where both have the measure; None where it has no pairs, or is best at a number in between."""
    ours, theirs = (data.every[method].values.get(metric) for method in (OURS, rival))
    if ours is None or theirs is None or metric in AIMS:
        return None
    difference = pooled_mean(ours - theirs, resampling)
    if len({recording(scene) for scene in data.methods[OURS].scenarios}) < TOO_FEW:
        difference = Interval(difference.value, np.nan, np.nan)
    return difference if np.isfinite(difference.value) else None


def _verdict(gain: float, *, significant: bool) -> str:
    """In words; `gain` is above zero where DriveGen is the better one."""
    if gain == 0:
        return "level"
    if significant:
        return "better" if gain > 0 else "worse"
    return "ahead" if gain > 0 else "behind"
