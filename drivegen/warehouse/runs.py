"""What a run of the pipeline left in its workspace, read back: scores, models with curves and times, of what code it is."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pyarrow.parquet as pq
import yaml
from numpy.typing import NDArray
from safetensors import safe_open

from drivegen.core.errors import UnusableInput
from drivegen.store.costs import COST
from drivegen.store.results import WHOLE_SCENE
from drivegen.warehouse.database import read_parts

METRICS, PIECES, PLOTS, COSTS = Path("reports/metrics"), Path("reports/pieces"), Path("reports/plots"), Path(".drivegen/costs")
"""Folders of a workspace."""

_WEIGHTS = {"train_generator": "generators", "train_planner": "planners", "train_selector": "selector"}
"""Folders below data/models, by the stage that trains what is in them."""


def read_scores(parts: list[Path]) -> tuple[tuple[str, ...], dict[str, NDArray[np.float64]]]:
    """Ids of N scenarios, and (S, N) by metric of S results parts, NaN where one has none; labels are left out.

    Raises UnusableInput where a part has other scenarios than the first.
    """
    of_scenes = [("sample", "==", WHOLE_SCENE)]
    tables = [pq.read_table(part, columns=["scenario", "metric", "value"], filters=of_scenes) for part in parts]
    scenarios = sorted(set(tables[0]["scenario"].to_pylist()))
    column = {scenario: n for n, scenario in enumerate(scenarios)}
    metrics = sorted({metric for table in tables for metric in table["metric"].unique().to_pylist()})
    values = {metric: np.full((len(parts), len(scenarios)), np.nan) for metric in metrics if not metric.startswith("label.")}
    for s, table in enumerate(tables):
        if set(table["scenario"].to_pylist()) != set(scenarios):
            raise UnusableInput(f"{parts[s]}: other scenes than in {parts[0]}: run `make tables` again")
        for scenario, metric, value in zip(*(values_of.to_pylist() for values_of in table.columns), strict=True):
            if metric in values:
                values[metric][s, column[scenario]] = value
    return tuple(scenarios), values


def read_curve(file: Path) -> dict[str, list[float]]:
    """Columns of a training curve (CSV) by name; what is left empty is NaN."""
    with file.open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    return {name: [float(row[name] or "nan") for row in rows] for name in (rows[0] if rows else {})}


@dataclass(frozen=True)
class Model:
    """A model that a run trained, or took over from one that did.

    Attributes:
        name: "<stage>/<item>", as costs are named. parameters: numbers in its weights, None where they are not there.
        curve: columns of its training curve by name. took: what its stage took here, by name; empty where it did not run.
        plateau: as `training.curve.plateau` says, None also where nobody asked.
        temperature: of sampling, as `generators.shared.learned.Learned.tune` chose it; None where it did not.
    """

    name: str
    parameters: int | None
    curve: dict[str, list[float]]
    took: dict[str, float]
    plateau: bool | None = None
    temperature: float | None = None


def read_models(workspace: Path) -> list[Model]:
    """Every model with a training curve."""
    took, models = read_costs(workspace / COSTS), []
    for file in sorted((workspace / PLOTS).rglob("*.csv")):
        stage = file.relative_to(workspace / PLOTS).parts[0].removesuffix(".csv")
        weights = workspace / "data/models" / _WEIGHTS[stage] / (file.stem if file.stem != stage else "")
        name = f"{stage}/{file.stem}"
        metrics = workspace / METRICS / file.relative_to(workspace / PLOTS).with_suffix(".json")
        said = orjson.loads(metrics.read_bytes()) if metrics.exists() else {}
        chosen = said.get("plateau"), said.get("sampling_temperature")
        models.append(Model(name, count_weights(weights), read_curve(file), took.get(name, {}), *chosen))
    return models


def read_costs(folder: Path) -> dict[str, dict[str, float]]:
    """What stages took, by "<stage>/<item>", then by name; those that were restored from the cache are not there."""
    costs: dict[str, dict[str, float]] = {}
    for cost in read_parts(sorted(folder.glob("*.parquet")), COST).to_pylist():
        costs.setdefault(f"{cost['stage']}/{cost['item']}", {})[cost["name"]] = cost["value"]
    return costs


def count_weights(folder: Path) -> int | None:
    """How many numbers the weights below `folder` are, those that scale inputs included; None where there are none."""
    counts = []
    for file in sorted(folder.rglob("*.safetensors")):
        with safe_open(file, framework="np") as weights:
            counts += [prod(weights.get_slice(name).get_shape()) for name in weights.keys()]  # noqa: SIM118  # no mapping
    return sum(counts) if counts else None


def read_param(workspace: Path, name: str) -> Any:
    """A number of the run's own params.yaml by its dotted name; None where it has none."""
    file = workspace / "params.yaml"
    value = yaml.safe_load(file.read_text()) if file.exists() else None
    for word in name.split("."):
        value = value.get(word) if isinstance(value, Mapping) else None
    return value


def read_codes(workspaces: Mapping[str, Path]) -> list[dict[str, Any]]:
    """[{commit, changed, runs}]: runs of one commit, whether files differed from it; None where nobody noted it."""
    runs_of: dict[tuple[Any, Any], list[str]] = {}
    for run, workspace in workspaces.items():
        file = workspace / ".drivegen" / "code.json"
        code = orjson.loads(file.read_bytes()) if file.exists() else {"commit": None, "changed": None}
        runs_of.setdefault((code["commit"], code["changed"]), []).append(run)
    return [{"commit": commit, "changed": changed, "runs": runs} for (commit, changed), runs in runs_of.items()]
