"""Which runs the published tables ask for, and that they are made without touching this workspace."""

from pathlib import Path

import pytest
import yaml

from drivegen.core.settings import read_section
from flows.rooms import FRONT, MEASURED, PARTS, rooms
from flows.tables import nearest

PUBLISH = {
    "seeds": [7, 8],
    "sampling_seeds": [7, 17],
    "temperatures": [0.5],
    "params": {"run.workers": 1},
    "data": {
        "corpus": {"folder": "", "params": {}, "folders": {}, "front": True},
        "real": {
            "folder": "recordings",
            "params": {"ingest.source": "real"},
            "folders": {"ingest.root": "FOLDER", "ingest.roots": {"real": "FOLDER"}},
            "front": False,
        },
    },
}


def test_every_data_set_is_run_with_every_pair_of_seeds_and_its_front_with_the_first(tmp_path: Path) -> None:
    (tmp_path / "recordings").mkdir()
    found = {room.name: room for room in rooms("quality", {"publish": PUBLISH}, tmp_path)}
    assert list(found) == [
        "corpus/7-7", "corpus/7-17", "corpus/8-7", "corpus/8-17", "corpus/t0.5", "real/7-7", "real/7-17", "real/8-7", "real/8-17",
    ]  # fmt: skip
    assert found["real/8-17"].params == {
        "run.workers": 1, "ingest.source": "real", "ingest.root": str(tmp_path / "recordings"),
        "ingest.roots": {"real": str(tmp_path / "recordings")}, "run.training_seed": 8, "run.sampling_seed": 17,
    }  # fmt: skip
    assert (found["real/8-7"].measured, found["corpus/t0.5"].measured) == (MEASURED, FRONT)
    assert found["corpus/t0.5"].params["run.own"] == ["drivegen"]


def test_a_run_begins_with_what_one_of_the_same_training_seed_made(tmp_path: Path) -> None:
    (tmp_path / "recordings").mkdir()
    asked = list(rooms("quality", {"publish": PUBLISH}, tmp_path))
    found = [nearest(room, asked[:n]) for n, room in enumerate(asked)]
    assert [room and room.name for room in found] == [
        None, "corpus/7-7", "corpus/7-17", "corpus/8-7", "corpus/7-17", "corpus/7-17", "real/7-7", "corpus/8-17", "real/8-7",
    ]  # fmt: skip


def test_recordings_that_are_not_there_are_left_out(tmp_path: Path) -> None:
    assert [room.name for room in rooms("quality", {"publish": PUBLISH}, tmp_path)] == [
        "corpus/7-7", "corpus/7-17", "corpus/8-7", "corpus/8-17", "corpus/t0.5",
    ]  # fmt: skip


def test_the_parameters_that_runs_replace_are_in_params_yaml(tmp_path: Path) -> None:
    from flows.workspace import overridden

    values = yaml.safe_load((Path(__file__).parents[2] / "params.yaml").read_text())
    data_sets = read_section("publish.data")
    for data in data_sets.values():
        (tmp_path / data["folder"]).mkdir(parents=True, exist_ok=True)
    asked = list(rooms("quality", values, tmp_path))
    assert len(asked) >= 3 * len(data_sets)
    for room in asked:
        overridden(values, room.params)  # raises KeyError for a name that is not there


@pytest.mark.parametrize("part", PARTS)
def test_what_the_runs_of_a_part_replace_is_in_params_yaml(part: str, tmp_path: Path) -> None:
    from flows.workspace import overridden

    values = yaml.safe_load((Path(__file__).parents[2] / "params.yaml").read_text())
    for room in rooms(part, values, tmp_path):
        overridden(values, room.params)  # raises KeyError for a name that is not there


def test_the_tables_of_drivers_are_made_from_every_data_set_that_is_there(tmp_path: Path) -> None:
    from flows.workspace import overridden

    values = yaml.safe_load((Path(__file__).parents[2] / "params.yaml").read_text())
    assert [room.name for room in rooms("drivers", values, tmp_path)] == [
        "drivers/sumo_corpus",
        "drivers/unseen",
        "drivers/paper",
    ]
    for data in read_section("publish_drivers.data").values():
        (tmp_path / data["folder"]).mkdir(parents=True, exist_ok=True)
    asked = list(rooms("drivers", values, tmp_path))
    assert [room.name for room in asked] == [f"drivers/{name}" for name in read_section("publish_drivers.data")]
    for room in asked:
        overridden(values, room.params)
