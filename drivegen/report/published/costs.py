"""What a thousand generated scenarios cost, method by method, by the stages that made the published runs."""

from collections.abc import Mapping, Sequence

import numpy as np

from drivegen.core.methods import Method
from drivegen.report.published.results import DataSet
from drivegen.report.table import RESTORED, Row, Table, number, row

COSTS_NOTE = (
    "Whole stages over all their processes: starting them, reading scenarios and writing samples are in it, and the log's own "
    "row is nothing but that. DriveGen's has two such stages; the one that chooses goals scores its choice against the log, too, "
    "with bootstrap. `drivegen bench` times the work alone, on scenes of its own, and so gives a smaller figure."
)

Took = Mapping[str, Mapping[str, float]]
"""What stages of one run took: "<stage>/<item>" -> name -> value."""


def costs(data: DataSet, runs: Sequence[Took], samples: int | None) -> Table:
    """One row a method; `runs` are what the stages of each training seed took. Means, and the whole range.

    `samples` of each scene were drawn; None if unknown.
    """
    lines = tuple(_line(name, data.rows[name], runs, data.rolled_out) for name in data.rows if name in data.methods)
    heads = ("", "CPU-s per 1000 scenarios", "of it choosing goals", "peak memory [MB]")
    notes = (
        f"{'All' if samples is None else samples} samples of each of {data.rolled_out} scenarios, mean and range over the runs "
        f"in which the stage ran, of {len(runs)}; a figure without a range is of one run. Other machines have others.",
        COSTS_NOTE,
    )
    return Table(f"costs-{data.name}", f"What generating costs: {data.title}", heads, lines, notes)


def _line(name: str, method: Method, runs: Sequence[Took], scenes: int) -> Row:
    whole, choosing, memory = [], [], []
    for run in runs:
        generating = next((took for at, took in run.items() if at.startswith("rollout") and at.endswith(f"/{name}")), None)
        chosen = run.get(f"goals/{method.goals}") if method.goals else {}
        if not generating or chosen is None:
            continue
        whole.append((generating["cpu_seconds"] + chosen.get("cpu_seconds", 0.0)) / scenes * 1000)
        choosing.append(chosen.get("cpu_seconds", 0.0) / scenes * 1000)
        memory.append(max(generating["peak_megabytes"], chosen.get("peak_megabytes", 0.0)))
    return row(method.title, _range(whole), _range(choosing) if method.goals else "–", _range(memory), origin="ours")


def _range(values: Sequence[float]) -> str:
    if not values:
        return RESTORED
    mean, low, high = (number(round(float(f(values)))) for f in (np.mean, np.min, np.max))
    return f"{mean} ({low} to {high})" if len(values) > 1 else mean
