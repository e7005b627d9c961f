"""The runs behind the published tables, read back: what every method scored, who chose goals how well, what was trained."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import orjson

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.methods import Method
from drivegen.report.evidence import words_of_training
from drivegen.report.published.costs import Took
from drivegen.report.published.results import OURS, DataSet, Results, Run, set_numbers, split, tracks
from drivegen.report.published.training import Trained
from drivegen.store.scenarios import read_shard, shards
from drivegen.warehouse.runs import COSTS, METRICS, read_costs, read_models, read_scores

SCENARIOS = Path("data/scenarios/test")
"""Where a run keeps the scenarios that it is measured on."""


def read_data_set(
    folder: Path, title: str, runs: Sequence[Run], about: Mapping[str, Method], *, by_scene: bool
) -> DataSet | None:
    """All runs of the data set that `folder` is named after; None where none was evaluated.

    `about` is every generator in the tables' order. Raises UnusableInput for results of one that is not among them, and where a
    run lacks a method that another one has: means are over all runs.
    """
    evaluated = tuple(run for run in runs if (folder / run.folder / METRICS / "quality").is_dir())
    if not evaluated:
        return None
    places = [folder / run.folder / METRICS for run in evaluated]
    methods = _methods(folder, places, about)
    results, left_out = split({method: read_results(places, method, _chosen_by(method, places[0])) for method in methods})
    scenes = folder / evaluated[0].folder / SCENARIOS
    logs = (scene for shard in (shards(scenes) if scenes.is_dir() else ()) for scene in read_shard(shard))
    trained = words_of_training(read_json(places[0] / "ingest.json"))
    counted, added = tracks(logs, results), _added(places, results)
    return DataSet(
        folder.name,
        title,
        trained,
        evaluated,
        about,
        results,
        by_scene,
        counted,
        added,
        left_out,
    )


def _added(places: Sequence[Path], methods: Mapping[str, Results]) -> dict[str, Results]:
    """See `DataSet.added`: of the methods that every run combined anew."""
    results_of = {}
    for name, results in methods.items():
        files = [place.parent / "pieces/additions" / f"{name}.parquet" for place in places]
        if not all(file.exists() for file in files):
            continue
        scenarios, values = read_scores(files)
        for added in dict.fromkeys(metric.partition("/")[0] for metric in values if "/" in metric):
            own = {metric.removeprefix(f"{added}/"): cells for metric, cells in values.items() if metric.startswith(f"{added}/")}
            results_of[f"{name}/{added}"] = Results(scenarios, {**own, "steps": values["steps"]}, {}, results.chosen_by).averaged
    return results_of


def _methods(folder: Path, places: Sequence[Path], about: Mapping[str, Method]) -> list[str]:
    """The methods that the runs have results of. Raises UnusableInput where one is no generator, or not every run has it."""
    methods = sorted({file.stem for place in places for file in (place / "quality").glob("*.parquet")})
    if strangers := [method for method in methods if method not in about]:
        file = f"drivegen/generators/{strangers[0]}.py"
        raise UnusableInput(f"{folder} has results of {strangers[0]!r}, which is no generator: write {file}, or remove the run")
    expected = [place / "quality" / f"{method}.parquet" for place in places for method in methods]
    if missing := [file for file in expected if not file.exists()]:
        raise UnusableInput(f"{missing[0]} is not there, but another run has it: run `make tables`, or move this run elsewhere")
    return methods


def _chosen_by(method: str, metrics: Path) -> str:
    """Who chose goals, as the stage goals has written it down, else as the method's plugin or its selector says."""
    plugin = plugins.load("generators", method)
    if plugin.about.goals is None:
        return str(plugin.backend)
    measured = metrics / "goals" / f"{plugin.about.goals}.json"
    return str(read_json(measured)["described"] if measured.exists() else plugins.load("selectors", plugin.about.goals).described)


def read_temperatures(folder: Path, temperatures: Iterable[float]) -> dict[float, Results]:
    """DriveGen's averaged results in the runs `t<temperature>` of a data set's folder, of those that were evaluated."""
    places = {temperature: folder / f"t{temperature}" / METRICS for temperature in temperatures}
    return {
        temperature: read_results([place], OURS, _chosen_by(OURS, place)).averaged
        for temperature, place in places.items()
        if (place / "quality" / f"{OURS}.parquet").exists()
    }


def read_goal_metrics(folder: Path, runs: Sequence[Run]) -> dict[str, list[Any]]:
    """What the stage goals measured of each selector, one a training seed: futures have no part in it."""
    files = sorted(file for run in _first_of_each(runs) for file in (folder / run.folder / METRICS / "goals").glob("*.json"))
    names = dict.fromkeys(file.stem for file in files)
    return {name: [read_json(file) for file in files if file.stem == name] for name in names}


def read_results(places: Sequence[Path], method: str, chosen_by: str) -> Results:
    """One method over its runs, a folder of results each; scenes in the first one's order."""
    scenarios, values = read_scores([place / "quality" / f"{method}.parquet" for place in places])
    details = [set_numbers(read_json(place / "quality_details" / f"{method}.json")) for place in places]
    sets = {key: [numbers[key] for numbers in details if key in numbers] for key in details[0]}
    return Results(scenarios, values, sets, chosen_by, _plateau(places, method))


def _plateau(places: Sequence[Path], method: str) -> bool | None:
    """See `Results.plateau`; DriveGen's models are its planner and, where it follows it, its goal selector."""
    plugin = plugins.load("generators", method)
    if plugin.about.goals is None:
        files = [f"train_generator/{getattr(plugin, 'name', method)}.json"]
    else:
        files = ["train_planner/*.json", *(["train_selector.json"] if plugin.about.goals == "learned" else [])]
    answers = [read_json(file).get("plateau") for place in places for name in files for file in sorted(place.glob(name))]
    return None if not answers or (None in answers and False not in answers) else all(answers)


def read_trained(runs: Path, data_sets: Iterable[DataSet]) -> list[Trained]:
    """Every model that was trained, once: runs of other data take it over, and only the run that trained it has its times."""
    models: dict[tuple[str, str, int], Trained] = {}
    for data in data_sets:
        for run in _first_of_each(data.runs):
            place = runs / data.name / run.folder
            trained_on = read_json(place / METRICS / "ingest.json")["trained_on"]
            lists = read_costs(place / COSTS).get("goal_lists/goal_lists", {}).get("cpu_seconds")
            for model in read_models(place):
                key = (trained_on, model.name, run.training)
                if key not in models or (model.took and not models[key].model.took):
                    models[key] = Trained(trained_on, run.training, model, lists)
    return list(models.values())


def _first_of_each(runs: Iterable[Run]) -> list[Run]:
    """The first run of every training seed: the others have its models."""
    return list({run.training: run for run in reversed(list(runs))}.values())[::-1]


def read_took(runs: Path, data: DataSet) -> list[Took]:
    """What the stages of each run of a data set took."""
    return [read_costs(runs / data.name / run.folder / COSTS) for run in data.runs]


def read_json(path: Path) -> Any:
    """The contents of a JSON file."""
    return orjson.loads(path.read_bytes())
