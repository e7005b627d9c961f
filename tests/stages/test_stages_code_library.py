"""The training logs whose codes LCTGen places by."""

from dataclasses import replace

import pytest

from drivegen.core.errors import MissingTool
from drivegen.store.scenarios import write_shard
from stages import _code_library
from stages._code_library import library
from tests.scenes import busy_crossing


@pytest.fixture
def split(tmp_path):
    """Three shards of three scenes, one of which was never recorded."""
    for shard in "abc":
        scenes = [busy_crossing(11, f"{shard}-{row}") for row in range(3)]
        scenes[2] = replace(scenes[2], log=None if shard == "b" else scenes[2].log)
        write_shard(tmp_path / "train" / f"shard-{shard}.parquet", scenes)
    return tmp_path


def test_the_logs_are_of_all_shards(split):
    names = [f"{shard}-{row}" for shard in "abc" for row in range(3)]
    names.remove("b-2")
    assert [scene.scenario_id for scene in library(split, 7)] == names


def test_of_many_logs_some_are_drawn(split, monkeypatch):
    monkeypatch.setattr(_code_library, "LOGS", 5)
    first, again, other = ([scene.scenario_id for scene in library(split, seed)] for seed in (7, 7, 8))
    assert first == again == sorted(first)
    assert 4 <= len(first) <= 5
    assert first != other


def test_a_missing_split_is_named(tmp_path):
    with pytest.raises(MissingTool, match="run the ingest stage"):
        next(library(tmp_path, 7))
