"""Door `publish`: the published tables from the runs that `python -m flows tables` made; a stage of no dvc.yaml.

argv: folder of runs (<data set>/<training seed>, and <data set>/t<temperature>, each a workspace whose reports/metrics hold
what was measured), folder to write: scenario_quality.json, a list of {data, method, metric, value, low, high, n, seeds,
selector}; every table as Markdown; provenance.json.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import orjson
import pyarrow.parquet as pq

from drivegen import plugins
from drivegen.errors import UnusableInput
from drivegen.report import published, published_tables
from drivegen.report.published import DataSet, Results
from drivegen.report.table import Table
from drivegen.seeds import rng
from drivegen.store.files import whole, write_json
from drivegen.store.results import run_id
from stages._door import enter, require

METRICS = Path("reports/metrics")
_PINNED = ("drivegen", "numpy", "torch", "libsumo", "numba")


@dataclass(frozen=True)
class About:
    """A data set of `publish.data`.

    Attributes:
        title: in words. folder: below the folder of real recordings, "" where none is needed.
        params: what differs from params.yaml. folders: the same for values that name the folder (FOLDER stands for it).
        front: whether DriveGen is run at every temperature. by_scene: too few scenes to average.
    """

    title: str
    folder: str
    params: dict[str, Any]
    folders: dict[str, Any]
    front: bool
    by_scene: bool


@dataclass(frozen=True)
class Params:
    """Section `publish`.

    Attributes:
        draws: bootstrap draws. seeds: of training. temperatures: at which the front of error and diversity is measured.
        params: what differs from params.yaml in every run. data: data sets, in the order of the tables.
        transfer: pairs of data sets whose order of methods is compared. training: pairs of data sets with the same scenes, by
            models that learnt from less and from more.
    """

    seed: int
    draws: int
    seeds: tuple[int, ...]
    temperatures: tuple[float, ...]
    params: dict[str, Any]
    data: dict[str, About]
    transfer: tuple[tuple[str, ...], ...]
    training: tuple[tuple[str, ...], ...]


def main(params: Params, runs: Path, out: Path) -> None:
    """Read every run, pool, write."""
    require(runs, "run `make tables`, which makes the runs and then calls this")
    rows: list[dict[str, Any]] = []
    tables: list[Table] = []
    known, missing = {}, []
    for name, about in params.data.items():
        data = _data_set(runs / name, name, about, params)
        if data is None:
            missing.append(name)
            continue
        pooled = published.pool(data, params.draws, rng(params.seed, "publish", "pool", name))
        known[name] = (data, pooled)
        rows += published.rows(data, pooled)
        tables += published_tables.tables(data, pooled, params.draws, rng(params.seed, "publish", "paired", name))
        at = {t: results for t in params.temperatures if (results := _at_temperature(runs / name / f"t{t}"))}
        if at:
            tables.append(published_tables.front(data, at, pooled))
    tables += [published_tables.transfer(*known[a], *known[b]) for a, b in params.transfer if a in known and b in known]
    for less, more in params.training:
        if less in known and more in known:
            stream = rng(params.seed, "publish", "training", more)
            tables.append(published_tables.training(known[less][0], known[more][0], params.draws, stream))
    if not rows:
        raise UnusableInput(f"{runs} holds no run that was evaluated: run `make tables`", reason="no-runs")
    _write(out, rows, tables, _provenance(params, runs, sorted(known)))
    print(f"publish: {len(rows)} figures of {', '.join(known)}; not measured: {', '.join(missing) or 'none'}")


def _data_set(folder: Path, name: str, about: About, params: Params) -> DataSet | None:
    """All seeds of a data set; None where it was not run."""
    seeds = tuple(seed for seed in params.seeds if (folder / str(seed) / METRICS / "quality").is_dir())
    if not seeds:
        return None
    places = [folder / str(seed) / METRICS for seed in seeds]
    methods = sorted({file.stem for place in places for file in (place / "quality").glob("*.parquet")})
    results = {method: _results(places, method) for method in methods if method in published.METHODS}
    ingest = _json(places[0] / "ingest.json")
    said = f"Models were trained on: {ingest['trained_on']}." + (f" {ingest['note']}." if ingest["note"] else "")
    return DataSet(name, about.title, said, seeds, results, about.by_scene)


def _results(places: list[Path], method: str) -> Results:
    """One method over its seeds, scenes in the first seed's order. Raises UnusableInput where seeds have other scenes."""
    parts = [pq.read_table(place / "quality" / f"{method}.parquet") for place in places]
    scenarios = sorted(set(parts[0]["scenario"].to_pylist()))
    column = {scenario: n for n, scenario in enumerate(scenarios)}
    metrics = sorted({metric for part in parts for metric in part["metric"].unique().to_pylist()})
    values = {metric: np.full((len(parts), len(scenarios)), np.nan) for metric in metrics if not metric.startswith("label.")}
    for s, part in enumerate(parts):
        if set(part["scenario"].to_pylist()) != set(scenarios):
            raise UnusableInput(f"{places[s]}: other scenes than in {places[0]}: run `make tables` again")
        for scenario, metric, value in zip(*(part[c].to_pylist() for c in ("scenario", "metric", "value")), strict=True):
            if metric in values:
                values[metric][s, column[scenario]] = value
    details = [published.set_numbers(_json(place / "quality_details" / f"{method}.json")) for place in places]
    sets = {key: [found[key] for found in details if key in found] for key in details[0]}
    return Results(tuple(scenarios), values, sets, _chosen_by(method))


def _at_temperature(folder: Path) -> Results | None:
    place = folder / METRICS
    return _results([place], "drivegen") if (place / "quality" / "drivegen.parquet").exists() else None


def _chosen_by(method: str) -> str:
    """Who chose goals, as the method's plugin or its selector says."""
    plugin = plugins.load("generators", method)
    if plugin.selector is None:
        return str(plugin.backend)
    return str(plugins.load("selectors", plugin.selector).described)


def _provenance(params: Params, runs: Path, known: list[str]) -> dict[str, Any]:
    """What the tables were made from and what they lack; no times and no paths, so the same runs give the same bytes."""
    places = [place for name in known for place in sorted((runs / name).iterdir()) if (place / METRICS).is_dir()]
    made = {str(place.relative_to(runs)): run_id({}, [place / METRICS]) for place in places}
    wanted = [f"{name}/{seed}" for name in params.data for seed in params.seeds]
    wanted += [f"{name}/t{t}" for name, about in params.data.items() if about.front for t in params.temperatures]
    return {
        "seed": params.seed,
        "bootstrap_draws": params.draws,
        "runs": made,
        "runs_missing": [name for name in wanted if name not in made],
        "versions": {name: version(name) for name in _PINNED},
    }


def _write(out: Path, rows: list[dict[str, Any]], tables: list[Table], provenance: dict[str, Any]) -> None:
    write_json(out / "scenario_quality.json", rows)
    write_json(out / "provenance.json", provenance)
    for name, text in _files(tables, provenance):
        with whole(out / name) as temporary:
            temporary.write_text(text, encoding="utf-8")


def _files(tables: list[Table], provenance: dict[str, Any]) -> Iterator[tuple[str, str]]:
    for table in tables:
        yield f"{table.name}.md", table.markdown()
    lines = [f"* [{table.title}]({table.name}.md)" for table in tables]
    made, missing = len(provenance["runs"]), provenance["runs_missing"]
    whole_set = f"From all {made} runs that `publish` of params.yaml asks for."
    partial = f"INCOMPLETE: from {made} of {made + len(missing)} runs; not there: {', '.join(missing)}."
    head = ["# Published tables", "", partial if missing else whole_set, ""]
    head += ["`provenance.json` says from what, `scenario_quality.json` has all figures.", ""]
    yield "README.md", "\n".join([*head, *lines, ""])


def _json(path: Path) -> Any:
    return orjson.loads(path.read_bytes())


if __name__ == "__main__":
    enter("publish", Params, main)
