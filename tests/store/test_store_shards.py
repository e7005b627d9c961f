"""Shards of scenarios and samples: what is written is read back, whole or not at all."""

from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.store.rejected import read_rejected, rejected_by_method, write_rejected
from drivegen.store.samples import read_samples, write_samples
from drivegen.store.scenarios import VERSION, read_shard, shards, write_shard
from tests.scenes import any_scenario, noisy_samples, rejected_of


def assert_same(one: Any, other: Any) -> None:
    """Equal down to the type and last bit of every array."""
    assert type(one) is type(other)
    if is_dataclass(one):
        for field in fields(one):
            assert_same(getattr(one, field.name), getattr(other, field.name))
    elif isinstance(one, np.ndarray):
        assert one.dtype.kind == other.dtype.kind
        assert one.dtype.kind == "U" or one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    else:
        assert one == other


@given(st.lists(st.integers(0, 10_000), max_size=4))
@settings(max_examples=20, deadline=None)
def test_scenarios_come_back_bit_by_bit(tmp_path_factory: pytest.TempPathFactory, seeds: list[int]) -> None:
    path = tmp_path_factory.mktemp("store") / "shard-00000.parquet"
    written = [any_scenario(seed, f"any-{i}") for i, seed in enumerate(seeds)]
    write_shard(path, written)
    read = read_shard(path)
    assert len(read) == len(written)
    for one, other in zip(written, read, strict=True):
        other.validate()
        assert_same(one, other)


def test_a_scenario_without_a_log_stays_without(tmp_path: Path) -> None:
    written = [replace(any_scenario(1), log=None), any_scenario(2)]
    write_shard(tmp_path / "s.parquet", written)
    first, second = read_shard(tmp_path / "s.parquet")
    assert first.log is None
    assert_same(second, written[1])


def test_samples_come_back_bit_by_bit(tmp_path: Path) -> None:
    written = [noisy_samples(any_scenario(seed, f"any-{seed}"), count, seed) for seed, count in ((1, 10), (2, 1), (3, 4))]
    write_samples(tmp_path / "s.parquet", written)
    for one, other in zip(written, read_samples(tmp_path / "s.parquet"), strict=True):
        assert_same(one, other)


def test_equal_content_gives_equal_bytes_also_after_reading(tmp_path: Path) -> None:
    write_shard(tmp_path / "a.parquet", [any_scenario(4), any_scenario(5)])
    write_shard(tmp_path / "b.parquet", read_shard(tmp_path / "a.parquet"))
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()


def test_arrays_may_be_written_into(tmp_path: Path) -> None:
    write_shard(tmp_path / "s.parquet", [any_scenario(4)])
    scenario = read_shard(tmp_path / "s.parquet")[0]
    assert scenario.log is not None
    scenario.log.position[0, 0] = 7
    scenario.log.valid[0, 0] = False


def test_shards_are_listed_in_order(tmp_path: Path) -> None:
    for name in ("shard-00010.parquet", "shard-00002.parquet", "rejected.parquet", ".shard-00001.parquet.9.part"):
        (tmp_path / name).touch()
    assert [path.name for path in shards(tmp_path)] == ["shard-00002.parquet", "shard-00010.parquet"]
    assert shards(tmp_path / "nowhere") == []


def broken(tmp_path: Path) -> dict[str, Path]:
    good = tmp_path / "good.parquet"
    write_shard(good, [any_scenario(1)])
    table = pq.read_table(good)
    paths = {word: tmp_path / f"{word}.parquet" for word in ("empty", "truncated", "foreign", "samples", "old", "absent", "text")}
    paths["empty"].touch()
    paths["truncated"].write_bytes(good.read_bytes()[:-100])
    paths["text"].write_text("not Parquet at all, but longer than twelve bytes")
    pq.write_table(pa.table({"a": [1]}), paths["foreign"])
    write_samples(paths["samples"], [noisy_samples(any_scenario(1))])
    old = table.schema.metadata | {b"drivegen.version": b"0"}
    pq.write_table(table.replace_schema_metadata(old), paths["old"])
    return paths


@pytest.mark.parametrize(
    ("what", "reason"),
    [
        ("empty", "truncated"),
        ("truncated", "truncated"),
        ("text", "truncated"),
        ("absent", "truncated"),
        ("foreign", "foreign-file"),
        ("samples", "foreign-file"),
        ("old", "old-version"),
    ],
)
def test_a_file_that_is_no_shard_of_ours_is_refused_by_name(tmp_path: Path, what: str, reason: str) -> None:
    path = broken(tmp_path)[what]
    with pytest.raises(UnusableInput, match=path.name) as caught:
        read_shard(path)
    assert caught.value.reason == reason


def test_an_old_shard_says_which_version_it_is_and_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match=f"version 0, this DriveGen reads {VERSION}: run the stage"):
        read_shard(broken(tmp_path)["old"])


def test_rejected_trajectories_come_back_bit_by_bit_by_method_and_scenario(tmp_path: Path) -> None:
    written = [rejected_of(noisy_samples(any_scenario(seed, f"any-{seed}"), 2, seed)) for seed in (1, 2)]
    written.append(written[0].only(np.zeros(len(written[0]), np.bool_)))  # a scene in which nothing was turned down
    write_rejected(tmp_path / "drivegen.parquet", written)
    for one, other in zip(written, read_rejected(tmp_path / "drivegen.parquet"), strict=True):
        assert_same(one, other)
    write_rejected(tmp_path / "drivegen.parquet", written[:2])
    write_rejected(tmp_path / "other.parquet", [])
    found = rejected_by_method(tmp_path)
    assert {method: list(scenes) for method, scenes in found.items()} == {"drivegen": ["any-1", "any-2"], "other": []}
    assert rejected_by_method(tmp_path / "absent") == {}
