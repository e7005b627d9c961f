"""Long rows, their names, and the warehouse over them."""

from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.methods import read_methods
from drivegen.lm.ledger import CALLS
from drivegen.store import results
from drivegen.store.costs import COST, write_cost
from drivegen.store.results import RESULT, WHOLE_SCENE, Run, record_rows, result_rows, run_id, write_results
from drivegen.warehouse.database import build, query, read_parts, result_parts

RUN = Run("0123456789ab", "evaluate", "drivegen", "", 7, "learned")


def rows(run=RUN, **metrics):
    return result_rows(run, ["a", "b", "c"], {name.replace("__", "."): np.array(value) for name, value in metrics.items()})


def warehouse(folder, *parts):
    for i, part in enumerate(parts):
        write_results(folder / "metrics" / f"{i}.parquet", [part])
    write_cost(folder / "costs", "evaluate", "drivegen", {"cpu_seconds": 6.0, "scenarios": 3})
    results = read_parts(result_parts(folder / "metrics"), RESULT)
    costs = read_parts(sorted((folder / "costs").glob("*.parquet")), COST)
    build(folder / "drivegen.duckdb", {"results": results, "costs": costs, "calls": CALLS.empty_table()})
    return folder / "drivegen.duckdb"


def test_parts_are_written_as_they_come_and_rows_lie_in_row_groups(tmp_path, monkeypatch):
    parts = [rows(**{f"m{n}": [1.0, np.nan, n]}) for n in range(8)]
    write_results(tmp_path / "whole.parquet", [pa.concat_tables(parts)])
    write_results(tmp_path / "parts.parquet", iter(parts))
    assert (tmp_path / "whole.parquet").read_bytes() == (tmp_path / "parts.parquet").read_bytes()
    monkeypatch.setattr(results, "ROW_GROUP", 5)
    write_results(tmp_path / "groups.parquet", iter(parts))
    file = pq.ParquetFile(tmp_path / "groups.parquet")
    assert [file.metadata.row_group(n).num_rows for n in range(file.num_row_groups)] == [5, 5, 5, 1]
    assert file.read().equals(pq.read_table(tmp_path / "whole.parquet"))


def test_rows_are_one_number_of_one_scenario_each():
    table = rows(min_sade=[1.0, 2.0, np.nan], mean_sade=[4.0, 5.0, 6.0])
    assert table.schema == RESULT
    assert len(table) == 5
    found = {(r["scenario"], r["metric"]): r["value"] for r in table.to_pylist()}
    assert found["b", "min_sade"] == 2.0
    assert ("c", "min_sade") not in found
    assert set(table["run"].to_pylist()) == {RUN.run}


def test_the_same_rows_are_the_same_bytes(tmp_path):
    for name in ("one", "two"):
        write_results(tmp_path / name, [rows(min_sade=[1.0, 2.0, 3.0])])
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_a_part_without_rows_can_be_read(tmp_path):
    write_results(tmp_path / "none.parquet", [])
    assert read_parts([tmp_path / "none.parquet"], RESULT).num_rows == 0


def test_a_run_is_named_by_settings_and_contents(tmp_path):
    (tmp_path / "data").mkdir()
    file = tmp_path / "data" / "x"
    file.write_bytes(b"1")
    before = run_id({"seed": 7}, [tmp_path / "data"])
    assert run_id({"seed": 7}, [tmp_path / "data"]) == before
    assert run_id({"seed": 8}, [tmp_path / "data"]) != before
    file.write_bytes(b"2")
    changed = run_id({"seed": 7}, [tmp_path / "data"])
    file.rename(tmp_path / "data" / "y")
    assert len({before, changed, run_id({"seed": 7}, [tmp_path / "data"])}) == 3


def test_items_of_a_stage_are_runs_of_their_own(tmp_path):
    (tmp_path / "x").write_bytes(b"1")
    made = [Run.of("goals", item, {"seed": 7, "workers": 1}, [tmp_path / "x"]) for item in ("learned", "random")]
    assert made[0].run != made[1].run
    assert (made[0].item, made[0].seed, made[0].inputs) == ("learned", 7, str(tmp_path / "x"))
    assert made[0] == Run.of("goals", "learned", {"seed": 7, "workers": 2}, [tmp_path / "x"])


def test_records_become_rows_of_their_numbers_and_truth_values(tmp_path):
    found = record_rows(RUN, {"a": {"lanes": 3, "good": True, "kind": "ring"}, "b": {"lanes": None, "turn": 0.5}}).to_pylist()
    assert {(row["scenario"], row["metric"], row["value"]) for row in found} == {
        ("a", "lanes", 3),
        ("a", "good", 1),
        ("b", "turn", 0.5),
    }
    assert {row["sample"] for row in found} == {WHOLE_SCENE}


def test_the_warehouse_gives_back_every_row(tmp_path):
    part = rows(min_sade=[1.0, 2.0, 6.0])
    other = result_rows(Run("x", "drive", "", "idm", 7, "batch"), ["a"], {"collision": np.array([1.0])})
    made = warehouse(tmp_path, part, other)
    order = "order by stage, scenario, metric"
    assert query(made, f"from results {order}").to_pylist() == [*other.to_pylist(), *part.sort_by("scenario").to_pylist()]
    assert query(made, "select sum(value) as total from costs").to_pylist() == [{"total": 9.0}]


def test_views_average_per_method_and_by_kind_of_scene(tmp_path):
    one = {"label__road__junction": [1.0, 1.0, np.nan], "label__road__fast_road": [np.nan, np.nan, 1.0]}
    made = warehouse(tmp_path, rows(min_sade=[1.0, 2.0, 6.0], collision_per_vehicle=[0.0, 0.0, 0.3], **one))
    quality = query(made, "select method, min_sade, collision_per_vehicle, min_sfde from scenario_quality").to_pylist()
    assert quality == [{"method": "drivegen", "min_sade": 3.0, "collision_per_vehicle": pytest.approx(0.1), "min_sfde": None}]
    assert {m["metric"] for m in query(made, "from metrics").to_pylist()} == {"min_sade", "collision_per_vehicle"}
    by_label = query(made, "select label, mean from metrics_by_label where metric = 'min_sade' order by label").to_pylist()
    assert by_label == [{"label": "fast_road", "mean": 6.0}, {"label": "junction", "mean": 1.5}]
    assert query(made, "select cpu_seconds_per_scenario as s from cost_per_item").to_pylist() == [{"s": 2.0}]


@pytest.mark.parametrize(("steps", "mean"), [([71, 101, 101], 4.0), ([71, 71, 101], 1.5), ([71, 101, 71], 3.5)])
def test_views_average_scenes_of_the_length_that_most_have(tmp_path, steps, mean):
    other = replace(RUN, run="ba9876543210", method="bits")  # its runs have a length of their own
    labels = {"label__road__junction": [1.0, 1.0, 1.0]}
    made = warehouse(tmp_path, rows(min_sade=[1.0, 2.0, 6.0], steps=steps, **labels), rows(other, min_sade=[3.0, 3.0, 9.0]))
    for sql in (
        "select mean from metrics where method = 'drivegen' and metric = 'min_sade' and scenarios = 2",
        "select min_sade as mean from scenario_quality where method = 'drivegen'",
        "select mean from metrics_by_label where method = 'drivegen' and metric = 'min_sade' and scenarios = 2",
    ):
        assert query(made, sql).to_pylist() == [{"mean": mean}]
    assert query(made, "select min_sade from scenario_quality where method = 'bits'").to_pylist() == [{"min_sade": 5.0}]


def test_of_lengths_that_equally_many_scenes_have_the_largest_is_averaged(tmp_path):
    made = warehouse(tmp_path, rows(min_sade=[1.0, 2.0, 6.0], steps=[71.0, 101.0, 50.0]))
    assert query(made, "select min_sade from scenario_quality").to_pylist() == [{"min_sade": 2.0}]


def test_scenarios_are_counted_once_where_policies_of_several_seeds_drove_through_them(tmp_path):
    runs = [Run(f"run-{seed}", "drive_tuned", "drivegen", "gail", seed, "batch", "drive_tuned") for seed in (7, 8, 9)]
    labels = rows(label__road__junction=[1.0, 1.0, 1.0])
    made = warehouse(tmp_path, labels, *(rows(run, cr=[0.0, 0.0, float(run.seed == 8)]) for run in runs))
    [row] = query(made, "from metrics where metric = 'cr'").to_pylist()
    assert (row["scenarios"], row["results"], row["mean"]) == (3, 9, pytest.approx(1 / 9))
    [row] = query(made, "from metrics_by_label where metric = 'cr'").to_pylist()
    assert (row["scenarios"], row["mean"]) == (3, pytest.approx(1 / 9))


def test_the_warehouse_has_a_row_of_every_generator(tmp_path):
    made = warehouse(tmp_path, rows(min_sade=[1.0, 2.0, 6.0]))
    titles = {row["method"]: row["title"] for row in query(made, "from methods").to_pylist()}
    assert titles == {name: plugins.load("generators", name).about.title for name in plugins.names("generators")}


def test_choosing_goals_is_counted_for_every_method_that_follows_a_selectors(tmp_path):
    selectors = {name: method.goals for name, method in read_methods().items()}
    following = {name: selector for name, selector in selectors.items() if selector is not None}
    assert len(following) > 2
    seconds = {selector: 3.0 * n for n, selector in enumerate(dict.fromkeys(following.values()), 1)}  # two may follow one
    for method, selector in following.items():
        write_cost(tmp_path / "costs", "goals", selector, {"cpu_seconds": seconds[selector]})
        write_cost(tmp_path / "costs", "rollout", method, {"cpu_seconds": 30.0})
    made = warehouse(tmp_path, *(rows(replace(RUN, method=name), min_sade=[1.0, 2.0, 6.0]) for name in selectors))
    found = {row["method"]: row["of_it_choosing_goals"] for row in query(made, "from cost_of_methods").to_pylist()}
    assert found == {
        **dict.fromkeys(selectors, 0.0),
        **{name: 1000.0 / 3.0 * seconds[selector] for name, selector in following.items()},
    }


def test_a_warehouse_is_replaced_as_a_whole(tmp_path):
    made = warehouse(tmp_path, rows(min_sade=[1.0, 2.0, 6.0]))
    build(made, {"calls": CALLS.empty_table()})
    assert query(made, "select count(*) as n from results").to_pylist() == [{"n": 0}]
    assert [file.name for file in tmp_path.iterdir() if file.is_file()] == ["drivegen.duckdb"]


def test_a_truncated_part_is_named(tmp_path):
    write_results(tmp_path / "part.parquet", [rows(min_sade=[1.0, 2.0, 6.0])])
    (tmp_path / "part.parquet").write_bytes((tmp_path / "part.parquet").read_bytes()[:-40])
    with pytest.raises(UnusableInput, match=r"part\.parquet is not a Parquet file"):
        result_parts(tmp_path)


def test_a_part_with_other_columns_is_refused_or_left_alone(tmp_path):
    pq.write_table(rows(min_sade=[1.0, 2.0, 6.0]).drop_columns("seed"), tmp_path / "other.parquet")
    assert result_parts(tmp_path) == []
    with pytest.raises(UnusableInput, match="wanted run, stage"):
        read_parts([tmp_path / "other.parquet"], RESULT)
