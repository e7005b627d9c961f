"""Door `publish`: the published tables from the runs that `python -m flows tables` made; a stage of no dvc.yaml.

argv: folder of runs (<data set>/<training seed>, and <data set>/t<temperature>, each a workspace whose reports/metrics hold
what was measured), folder to write: scenario_quality.json, a list of {data, method, metric, value, low, high, n, seeds,
selector}; every table as Markdown, its picture as SVG; README.md; provenance.json.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import orjson

from drivegen import plugins
from drivegen.errors import UnusableInput
from drivegen.report import published, published_tables
from drivegen.report.published import DataSet, Pooled, Results
from drivegen.report.published_best import best
from drivegen.report.published_costs import costs
from drivegen.report.published_front import front
from drivegen.report.published_goals import goals
from drivegen.report.published_index import index
from drivegen.report.published_training import Trained, models
from drivegen.report.table import Table
from drivegen.seeds import rng
from drivegen.store.files import whole, write_json
from drivegen.store.results import run_id
from drivegen.store.runs import COSTS, METRICS, read_codes, read_costs, read_models, read_param, read_scores
from drivegen.store.scenarios import read_shard, shards
from stages._door import enter, require

SCENARIOS = Path("data/scenarios/test")
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
    known: dict[str, tuple[DataSet, Pooled]] = {}
    for name, about in params.data.items():
        data = _data_set(runs / name, name, about, params)
        if data is not None:
            pooled = published.pool(data, params.draws, rng(params.seed, "publish", "pool", name))
            known[name] = (data, pooled)
            rows += published.rows(data, pooled)
            tables += published_tables.few(data, _tables(data, pooled, runs / name, params))
    if not rows:
        raise UnusableInput(f"{runs} holds no run that was evaluated: run `make tables`", reason="no-runs")
    tables += [published_tables.transfer(*known[a], *known[b]) for a, b in params.transfer if a in known and b in known]
    for less, more in params.training:
        if less in known and more in known:
            stream = rng(params.seed, "publish", "training", more)
            found = published_tables.training(known[less][0], known[more][0], params.draws, stream)
            tables += published_tables.few(known[more][0], [found])
    tables += models(_trained(runs, [data for data, _ in known.values()]))
    most = max((data for data, _ in known.values()), key=lambda data: data.scenes)
    rooms = [runs / most.name / str(seed) for seed in most.seeds]
    tables.append(costs(most, [read_costs(room / COSTS) for room in rooms], read_param(rooms[0], "rollout.samples")))
    _write(out, rows, tables, {name: data.title for name, (data, _) in known.items()}, _provenance(params, runs))
    missing = [name for name in params.data if name not in known] or ["none"]
    print(f"publish: {len(rows)} figures of {', '.join(known)}; not measured: {', '.join(missing)}")


def _tables(data: DataSet, pooled: Pooled, folder: Path, params: Params) -> list[Table]:
    """All tables of one data set alone, the headline first."""
    streams = {what: rng(params.seed, "publish", what, data.name) for what in ("paired", "best")}
    first, paired, *others = published_tables.tables(data, pooled, params.draws, streams["paired"])
    found = [first, paired, *best(data, pooled, params.draws, streams["best"]), *others]
    at = {t: results for t in params.temperatures if (results := _at_temperature(folder / f"t{t}"))}
    if at and params.data[data.name].front:
        found.append(front(data, at, pooled, read_param(folder / str(data.seeds[0]), "rollout.generation.temperature")))
    files = sorted(file for seed in data.seeds for file in (folder / str(seed) / METRICS / "goals").glob("*.json"))
    chosen = {stem: [_json(file) for file in files if file.stem == stem] for stem in dict.fromkeys(file.stem for file in files)}
    return [*found, goals(data.name, data.title, chosen)] if chosen else found


def _data_set(folder: Path, name: str, about: About, params: Params) -> DataSet | None:
    """All seeds of a data set; None where it was not run."""
    seeds = tuple(seed for seed in params.seeds if (folder / str(seed) / METRICS / "quality").is_dir())
    if not seeds:
        return None
    places = [folder / str(seed) / METRICS for seed in seeds]
    methods = sorted({file.stem for place in places for file in (place / "quality").glob("*.parquet")})
    results, left_out = published.split({m: _results(places, m) for m in methods if m in published.METHODS})
    ingest = _json(places[0] / "ingest.json")
    said = f"Models were trained on: {ingest['trained_on']}." + (f" {ingest['note']}." if ingest["note"] else "")
    scenes = folder / str(seeds[0]) / SCENARIOS
    logs = (scene for shard in (shards(scenes) if scenes.is_dir() else ()) for scene in read_shard(shard))
    return DataSet(name, about.title, said, seeds, results, about.by_scene, published.tracks(logs, results), left_out)


def _results(places: list[Path], method: str) -> Results:
    """One method over its seeds, scenes in the first seed's order."""
    scenarios, values = read_scores([place / "quality" / f"{method}.parquet" for place in places])
    details = [published.set_numbers(_json(place / "quality_details" / f"{method}.json")) for place in places]
    sets = {key: [found[key] for found in details if key in found] for key in details[0]}
    return Results(scenarios, values, sets, _chosen_by(method))


def _trained(runs: Path, known: Iterable[DataSet]) -> list[Trained]:
    """Every model that was trained, once: runs of other data take it over, and only the run that trained it has its times."""
    found: dict[tuple[str, str, int], Trained] = {}
    for data in known:
        for seed in data.seeds:
            place = runs / data.name / str(seed)
            trained_on = _json(place / METRICS / "ingest.json")["trained_on"]
            lists = read_costs(place / COSTS).get("goal_lists/goal_lists", {}).get("cpu_seconds")
            for model in read_models(place):
                key = (trained_on, model.name, seed)
                if key not in found or (model.took and not found[key].model.took):
                    found[key] = Trained(trained_on, seed, model, lists)
    return list(found.values())


def _at_temperature(folder: Path) -> Results | None:
    known = (folder / METRICS / "quality" / "drivegen.parquet").exists()
    return _results([folder / METRICS], "drivegen").averaged if known else None


def _chosen_by(method: str) -> str:
    """Who chose goals, as the method's plugin or its selector says."""
    plugin = plugins.load("generators", method)
    return str(plugin.backend if plugin.selector is None else plugins.load("selectors", plugin.selector).described)


def _provenance(params: Params, runs: Path) -> dict[str, Any]:
    """What the tables were made from and what they lack; no times and no paths, so the same runs give the same bytes."""
    wanted = [f"{name}/{seed}" for name in params.data for seed in params.seeds]
    wanted += [f"{name}/t{t}" for name, about in params.data.items() if about.front for t in params.temperatures]
    there = {name: runs / name for name in sorted(wanted) if (runs / name / METRICS).is_dir()}
    return {
        "seed": params.seed,
        "bootstrap_draws": params.draws,
        "runs": {name: run_id({}, [place / METRICS]) for name, place in there.items()},
        "code": read_codes(there),
        "runs_missing": [name for name in wanted if name not in there],
        "versions": {name: version(name) for name in _PINNED},
    }


def _write(out: Path, rows: list[dict[str, Any]], tables: list[Table], titles: dict[str, str], made: dict[str, Any]) -> None:
    write_json(out / "scenario_quality.json", rows)
    write_json(out / "provenance.json", made)
    texts = {f"{table.name}.md": table.markdown().encode() for table in tables}
    texts |= {f"{table.name}.svg": table.picture for table in tables if table.picture}
    for name, text in {**texts, "README.md": index(tables, titles, made).encode()}.items():
        with whole(out / name) as temporary:
            temporary.write_bytes(text)


def _json(path: Path) -> Any:
    return orjson.loads(path.read_bytes())


if __name__ == "__main__":
    enter("publish", Params, main)
