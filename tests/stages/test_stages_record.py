"""Stage record on a small shard, read back."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
import rerun as rr

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.samples import Samples, Violation
from drivegen.report.evidence import Evidence, Link, Picture
from drivegen.report.pictures import read_collision_pictures
from drivegen.report.sections.driving import section
from drivegen.store.collisions import Where, read_pictured, write_pictured
from drivegen.store.goals import COLUMNS, GoalColumns, write_goals
from drivegen.store.rejected import write_rejected
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from drivegen.warehouse.tables import read_recordings
from stages import record
from tests.scenes import busy_crossing, noisy_samples, rejected_of

SHARD = "shard-00000.parquet"
PARAMS = record.Params(seed=7, scenes=2, compared=1, driven=2)


def goals_of(scene, per_vehicle=3) -> GoalColumns:
    """Three candidates a vehicle: a fifth, a half and all of its logged way."""
    places = scene.log.position[:, [20, 50, -1]].reshape(-1, 2)
    columns = {name: np.zeros(0, kind.to_pandas_dtype()) for name, kind in COLUMNS.items()}
    columns |= {
        "candidates": np.full(len(scene.vehicles), per_vehicle, np.int32),
        "position": places.ravel(),
        "place": places.ravel(),
        "leaves_after": np.full(len(places), np.inf, np.float32),
        "probability": np.tile(np.float32([0.2, 0.3, 0.5]), len(scene.vehicles)),
        "lane": np.zeros(len(places), np.int32),
    }
    return GoalColumns(scene.scenario_id, "learned", columns)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    root = tmp_path_factory.mktemp("record")
    scenes = [busy_crossing(60, f"scene-{letter}") for letter in "abc"]
    samples = [noisy_samples(scene, 2) for scene in scenes]
    for one in samples:
        one.goal[:] = 2
    write_shard(root / "test" / SHARD, scenes)
    for method in ("drivegen", "log", "other"):
        write_samples(root / "generated" / method / SHARD, [replace(one, method=method) for one in samples])
    write_goals(root / "goals" / "learned" / SHARD, [goals_of(scene) for scene in scenes])
    write_rejected(root / "rejected" / "drivegen.parquet", [rejected_of(one) for one in samples])
    for part in ("samples", "driven"):
        write_samples(root / "corner/1" / part / SHARD, samples)
    careful = [Samples.without_goals(s.scenario_id, "careful", s.log[:1][np.newaxis]) for s in scenes]
    hasty = [replace(one, violation=np.full((1, 1), Violation.COLLISION, np.uint16)) for one in careful]
    write_samples(root / "driven/careful.parquet", careful)
    write_samples(root / "driven/hasty.parquet", hasty)
    where = Where("scene-b", SHARD, sample=1, partner=2, step=20)
    write_pictured(root / "corner/1/collisions/0", b"png", "it came from the left", where)
    recorded(root, root / "recordings.json")
    return root


def recorded(root, listing, goals="goals"):
    """Run the stage; recordings lie beside their list."""
    places = [root / folder for folder in ("test", "generated", "rejected", goals, "corner", "driven")]
    record.main(PARAMS, *places, listing.parent / "recordings", listing)


def test_the_list_names_what_was_recorded(made):
    links = json.loads((made / "recordings.json").read_text())
    assert len(links) == 6
    collision = {"text": "Round 1, collision 1: scene-b", "href": "recordings/corner-1-0.rrd"}
    assert {**collision, "scenario": "scene-b", "sample": 1, "stage": "corner", "item": "1"} in links
    assert read_recordings(made / "recordings.json").to_pylist()[-1]["sample"] == 1
    assert all((made / link["href"]).is_file() for link in links)
    assert {(made / link["href"]).name for link in links} == {file.name for file in (made / "recordings").iterdir()}


def test_every_driver_is_in_the_same_scenes_and_the_report_draws_its_speed(made):
    links = [link for link in json.loads((made / "recordings.json").read_text()) if "speed" in link]
    assert len(links) == 2
    for link in links:
        assert set(link["speed"]) == {"logged", "careful", "hasty"}
        assert {len(speed) for speed in link["speed"].values()} == {60}
        assert link["collided"] == ["hasty"]
    [figure] = section(Evidence(results={"recordings": links})).figures
    assert figure.data.startswith(b"<?xml")
    assert f"hasty in {links[0]['scenario']}; hasty in {links[1]['scenario']}" in figure.caption
    assert section(Evidence(results={"recordings": []})).figures == ()


def test_chosen_goals_are_those_that_the_sample_follows(made):
    file = next(file for file in (made / "recordings").iterdir() if file.stem in ("scene-a", "scene-b", "scene-c"))
    chunks = {chunk.entity_path: chunk.to_record_batch() for chunk in rr.chunk.RrdReader(file).stream() if chunk.is_static}
    assert chunks["/world/goals/target"].column("Points3D:labels").to_pylist()[0] == ["2: 50%"]
    assert chunks["/world/goals/chosen"].column("Points3D:labels").to_pylist()[0] == ["2: 50%"] * 7
    assert len(chunks["/world/goals/candidates"].column("Points3D:positions").to_pylist()[0]) == 16
    assert "/bird_eye" in chunks


def test_a_picture_in_the_report_is_linked_to_its_recording(made):
    links = [Link(link["text"], link["href"]) for link in json.loads((made / "recordings.json").read_text())]
    assert read_collision_pictures(made / "corner", links) == (
        Picture("Round 1, collision 1", "it came from the left", b"png", "recordings/corner-1-0.rrd"),
    )
    assert read_collision_pictures(made / "corner", [])[0].recording == ""
    assert read_collision_pictures(made / "nowhere", links) == ()


def test_a_copy_of_a_round_is_no_round(made, tmp_path):
    for name in ("1", "1-backup"):
        shutil.copytree(made / "corner/1/collisions", tmp_path / name / "collisions")
    assert [one.name for one in read_pictured(tmp_path)] == ["corner-1-0"]


def test_a_damaged_place_of_a_collision_is_named(made, tmp_path):
    collisions = shutil.copytree(made / "corner/1/collisions", tmp_path / "1/collisions")
    for text, words in (("{", "is not JSON"), ('{"step": 3}', "0.json")):
        (collisions / "0.json").write_text(text)
        with pytest.raises(UnusableInput, match=words):
            read_pictured(tmp_path)


def test_methods_stand_side_by_side_on_one_clock(made):
    (file,) = (made / "recordings").glob("*-methods.rrd")
    chunks = [chunk for chunk in rr.chunk.RrdReader(file).stream() if "/world/methods" in chunk.entity_path]
    paths = {chunk.entity_path.removeprefix("/world/methods/") for chunk in chunks}
    assert paths == {"log/traffic", *(f"drivegen/{what}" for what in ("traffic", "samples", "goals", "rejected"))} | {
        "other/traffic",
        "other/samples",
    }
    lines = next(chunk for chunk in chunks if chunk.entity_path.endswith("other/samples")).to_record_batch()
    assert len(lines.column("LineStrips3D:strips").to_pylist()[0]) == 16  # two samples of eight vehicles
    goals = next(chunk for chunk in chunks if chunk.entity_path.endswith("drivegen/goals")).to_record_batch()
    assert len(goals.column("Points3D:positions").to_pylist()[0]) == 8  # both samples follow the same goal of each
    assert all("time" in chunk.timeline_names for chunk in chunks if not chunk.is_static)


def test_what_was_turned_down_is_shown_dashed_and_counted_where_there_is_any(made):
    (compared,) = (made / "recordings").glob("*-methods.rrd")
    alone = next(file for file in (made / "recordings").iterdir() if file.stem in ("scene-a", "scene-b", "scene-c"))
    chunks = {chunk.entity_path: chunk.to_record_batch() for chunk in rr.chunk.RrdReader(compared).stream() if chunk.is_static}
    (legend,) = chunks["/legend"].column("TextDocument:text").to_pylist()[0]
    assert "* drivegen: 16 turned down: 16 speed" in legend
    assert "* other" not in legend
    for file, where in ((compared, "/world/methods/drivegen/rejected"), (alone, "/world/rejected")):
        chunks = {c.entity_path: c.to_record_batch() for c in rr.chunk.RrdReader(file).stream() if c.is_static}
        dashes = np.array(chunks[where].column("LineStrips3D:strips").to_pylist()[0])
        assert dashes.shape[1:] == (2, 3)
        assert np.hypot(*np.diff(dashes[..., :2], axis=1)[:, 0].T).max() < 1.6
    lines = [
        c.to_record_batch().column("TextLog:text").to_pylist()
        for c in rr.chunk.RrdReader(alone).stream()
        if c.entity_path == "/verdicts"
    ]
    assert all("1 turned down: 1 speed" in row[0] for rows in lines for row in rows)


def test_the_same_scenes_are_drawn_again(made, tmp_path):
    recorded(made, tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (made / "recordings.json").read_bytes()


def test_missing_goals_are_named(made, tmp_path):
    with pytest.raises(MissingTool, match="run the goals stage"):
        recorded(made, tmp_path / "x.json", tmp_path)
    write_goals(tmp_path / "learned" / SHARD, [goals_of(busy_crossing(60, "another"))])
    with pytest.raises(UnusableInput, match="lacks scenario"):
        recorded(made, tmp_path / "x.json", tmp_path)
    assert not (tmp_path / "x.json").exists()
