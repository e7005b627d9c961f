"""A generator is one file and one entry in params.yaml: one that lies in a temporary folder is in every table."""

import sys
from pathlib import Path

import orjson
import pytest
import yaml
from dvc.repo import Repo

import drivegen.generators
from drivegen.checker.verdicts import write_limits_file
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.methods import RULES, read_methods
from drivegen.store.costs import write_cost
from drivegen.store.files import write_json
from drivegen.store.scenarios import write_shard
from drivegen.warehouse.database import query
from stages import collect, evaluate, publish, report, rollout_baseline
from stages._door import read_params
from tests.checking import LIMITS
from tests.scenes import busy_crossing

ROOT = Path(__file__).parents[2]
NAME, TITLE = "standstill", "Everybody stands"
FILE = f'''"""Everybody stands where they are."""

import numpy as np

from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import Trajectories

ABOUT = Method(
    title="{TITLE}", line="Nobody ever moves.", kind="rules", goals=None, trains_on="nothing", places=False, additions=(),
)


class Plugin:
    """Everybody stands."""

    about = ABOUT
    backend = "none"

    def __init__(self, models, settings):
        pass

    def generate(self, scenarios, samples, seed):
        return [Samples.without_goals(s.scenario_id, "{NAME}", _still(s, samples)) for s in scenarios]


def _still(scenario, samples):
    vehicles, steps = scenario.vehicles, scenario.steps
    shape = (samples, len(vehicles), steps)
    position = np.broadcast_to(vehicles.position[:, None], (*shape, 2)).copy()
    heading = np.broadcast_to(vehicles.heading[:, None], shape).copy()
    velocity = np.zeros((*shape, 2), np.float32)
    velocity[:, :, 0] = np.stack([np.cos(vehicles.heading), np.sin(vehicles.heading)], -1) * vehicles.speed[:, None]
    return Trajectories(position, heading, velocity, np.ones(shape, np.bool_))
'''


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project with a generator of its own: one file in a folder of plugins, one name in params.yaml; a shard of test scenes."""
    folder = tmp_path / "generators"
    folder.mkdir()
    (folder / f"{NAME}.py").write_text(FILE)
    monkeypatch.setattr(drivegen.generators, "__path__", [*drivegen.generators.__path__, str(folder)])
    monkeypatch.delitem(sys.modules, f"drivegen.generators.{NAME}", raising=False)  # of the test before, in its own folder
    params = yaml.safe_load((ROOT / "params.yaml").read_text())
    params["run"] |= {"baselines": [*params["run"]["baselines"], NAME], "workers": 1}
    params["rollout_baseline"]["samples"] = 2
    params["evaluate"] |= {"draws": 20, "splits": 2}
    params["tables"] = str(ROOT / params["tables"])
    (tmp_path / "params.yaml").write_text(yaml.safe_dump(params))
    scenes = [busy_crossing(60, f"recording-{letter}") for letter in "abc"]
    write_shard(tmp_path / "data/scenarios/test/shard-00000.parquet", scenes)
    write_limits_file(tmp_path / "data/models/limits.json", LIMITS)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def measure(name: str) -> None:
    """Roll out and evaluate one generator as the stages do."""
    metrics, test = Path("reports/metrics"), Path("data/scenarios/test")
    outs = (metrics / f"quality/{name}.parquet", metrics / f"quality_details/{name}.json", metrics / f"quality/{name}.json")
    params = read_params("rollout_baseline", rollout_baseline.Params)
    rollout_baseline.main(params, test, Path("data/models"), Path("data/generated") / name)
    evaluate.main(read_params("evaluate", evaluate.Params), test, Path("data/generated") / name, *outs)
    write_cost(Path(".drivegen/costs"), "rollout_baseline", name, {"cpu_seconds": 3.0, "peak_megabytes": 9.0})
    write_json(metrics / "ingest.json", {"trained_on": "toys", "note": ""})


def test_it_says_what_it_is_and_stands_in_its_place_of_the_tables(project: Path) -> None:
    methods = read_methods(["log", NAME, "constant_velocity"])
    assert methods[NAME] == plugins.load("generators", NAME).about
    assert [name for name, method in methods.items() if method.kind == RULES] == [NAME, "constant_velocity", "idm"]


def test_its_one_entry_makes_its_stages(project: Path) -> None:
    (project / "dvc.yaml").write_bytes((ROOT / "dvc.yaml").read_bytes())
    (project / ".dvc").mkdir()
    (project / ".dvc/config").write_text("[core]\n    no_scm = true\n    analytics = false\n")
    with Repo(str(project)) as repo:
        stages = {stage.addressing for stage in repo.index.stages}
    assert {f"rollout_baseline@{NAME}", f"evaluate_baseline@{NAME}"} <= stages


def test_it_is_in_every_table(project: Path) -> None:
    measure(NAME)
    results, costs = Path("reports/metrics"), Path(".drivegen/costs")
    none, params = project / "none", read_params("collect", collect.Params)
    folders = (none, costs, none, project / "params.yaml", *[none] * 3, Path("data/generated"), none)
    collect.main(params, results, *folders, project / "costs.md", project / "all.duckdb")
    made_by = query(project / "all.duckdb", f"select distinct stage from samples where method = '{NAME}'").to_pylist()
    assert made_by == [{"stage": "rollout_baseline"}]
    for table in ("results", "methods", "metrics", "scenario_quality", "metrics_by_label", "cost_of_methods"):
        assert query(project / "all.duckdb", f"select * from {table} where method = '{NAME}'").num_rows, table
    assert NAME in (project / "costs.md").read_text()
    generated = Path("data/generated")
    places = (Path("data/scenarios/test"), generated, none, none, none, none, costs, project / "index.html", project / "tables")
    report.main(read_params("report", report.Params), results, none, *places)
    rows = {file.stem: file.read_text() for file in (project / "tables").glob("*.md") if f"| {TITLE} " in file.read_text()}
    assert {"summary", "quality", "safety", "diversity", "realism", "scores", "distances"} <= set(rows)


def test_it_is_in_every_published_table_and_a_stranger_is_no_row_but_an_error(project: Path) -> None:
    measure(NAME)
    measure("constant_velocity")
    room = project / "runs/sumo_corpus/7-7"
    for name in ("reports", "data"):
        (room / name).parent.mkdir(parents=True, exist_ok=True)
        (room / name).symlink_to(project / name)
    params = read_params("tables.quality", publish.Params)
    publish.main(params, project / "runs", project / "out")
    rows = orjson.loads((project / "out/scenario_quality.json").read_bytes())
    assert {row["method"] for row in rows} == {NAME, "constant_velocity"}
    tables = {file.stem for file in (project / "out").glob("*.md") if TITLE in file.read_text()}
    assert {"quality-sumo_corpus", "paired-sumo_corpus", "safety-sumo_corpus", "costs-sumo_corpus"} <= tables
    (project / "generators" / f"{NAME}.py").rename(project / "elsewhere.py")
    with pytest.raises(
        UnusableInput, match=rf"has results of '{NAME}', which is no generator: write drivegen/generators/{NAME}\.py"
    ):
        publish.main(params, project / "runs", project / "out")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("ABOUT = Method", "WHAT = Method"), "must say what it is by `ABOUT = ...`"),
        (('kind="rules"', 'kind="magic"'), "is 'magic', which is none of ours, ablation"),
        (("places=False", "places=bool(0)"), "ABOUT must be made of literals"),
        (("goals=None, ", ""), "'goals' is missing"),
    ],
)
def test_a_file_that_does_not_say_what_it_is_is_named(project: Path, change: tuple[str, str], sentence: str) -> None:
    (project / "generators" / f"{NAME}.py").write_text(FILE.replace(*change))
    with pytest.raises(UnusableInput, match=sentence):
        read_methods()
