"""What the report reads from folders: every file by its name, nothing where there is no folder."""

from pathlib import Path

import numpy as np
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.render.png import png
from drivegen.report.measured import read_curves, read_results
from drivegen.report.pictures import MAP_WIDTH, read_map_pictures
from drivegen.store.files import write_json


def test_results_and_curves_are_named_by_their_path(tmp_path: Path) -> None:
    write_json(tmp_path / "quality/drivegen.json", {"min_sade": 1.5})
    (tmp_path / "train_planner").mkdir()
    (tmp_path / "train_planner/route_fm.csv").write_text("step,validation\n1,0.5\n2,\n")
    assert read_results(tmp_path) == {"quality/drivegen": {"min_sade": 1.5}}
    [curve] = read_curves(tmp_path)
    assert curve.title == "train_planner/route_fm"
    assert curve.columns["step"] == [1.0, 2.0]
    assert curve.columns["validation"][0] == 0.5
    assert np.isnan(curve.columns["validation"][1])


def test_a_result_that_is_not_json_is_named_with_a_remedy(tmp_path: Path) -> None:
    (tmp_path / "maps.json").write_text('{"half')
    with pytest.raises(UnusableInput, match=r"maps\.json is not JSON: remove it and run its stage again"):
        read_results(tmp_path)


def test_maps_are_the_first_by_name_with_their_words(tmp_path: Path) -> None:
    for name in ("b_road", "a_road", "c_road"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "map.png").write_bytes(png(np.zeros((2, MAP_WIDTH, 3), np.uint8)))
    write_json(tmp_path / "a_road/map.json", {"text": "a straight road"})
    assert [(p.title, p.caption) for p in read_map_pictures(tmp_path, 2)] == [("a road", "a straight road"), ("b road", "")]


def test_folders_that_are_not_there_hold_nothing(tmp_path: Path) -> None:
    absent = tmp_path / "absent"
    assert (read_results(absent), read_curves(absent), read_map_pictures(absent, 3)) == ({}, (), ())
