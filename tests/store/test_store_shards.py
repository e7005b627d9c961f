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

from drivegen.core import safe_parquet
from drivegen.core.errors import UnusableInput
from drivegen.store.lists import read_groups, write_shard_table
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
    words = ("empty", "truncated", "cut in its footer", "bit", "unsealed", "foreign", "samples", "old", "absent", "text")
    paths = {word: tmp_path / f"{word}.parquet" for word in words}
    paths["empty"].touch()
    raw = good.read_bytes()
    paths["truncated"].write_bytes(raw[: len(raw) // 2])
    paths["cut in its footer"].write_bytes(raw[:-100])
    paths["bit"].write_bytes(raw[:99] + bytes([raw[99] ^ 1]) + raw[100:])
    pq.write_table(table, paths["unsealed"])
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
        ("cut in its footer", "damaged"),
        ("bit", "damaged"),
        ("unsealed", "damaged"),
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


def test_an_empty_file_has_no_groups_of_rows(tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match=r"empty\.parquet is no whole shard") as caught:
        next(read_groups(broken(tmp_path)["empty"], "scenarios", VERSION))
    assert caught.value.reason == "truncated"


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


@given(place=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7), near_end=st.booleans())
@settings(max_examples=60, deadline=None)
def test_no_flipped_bit_is_taken(good: Path, place: float, bit: int, near_end: bool) -> None:
    raw = bytearray(good.read_bytes())
    first = len(raw) - 12_000 if near_end else 0  # most of so small a file is its footer
    raw[first + int(place * (len(raw) - first))] ^= 1 << bit
    flipped = good.with_name("flipped.parquet")
    flipped.write_bytes(raw)
    with pytest.raises(UnusableInput, match=r"flipped\.parquet"):
        read_shard(flipped)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("good") / "good.parquet"
    write_shard(path, [any_scenario(1), any_scenario(2)])
    return path


def tampered(name: str, change: Any) -> Any:
    """A scenario with one array of a dotted name changed, of the right shape and type."""

    def put(part: Any, words: list[str]) -> Any:
        if not words:
            return change(part.copy() if isinstance(part, np.ndarray) else part)
        return replace(part, **{words[0]: put(getattr(part, words[0]), words[1:])})

    return put(any_scenario(1), name.split("."))


def first_is(value: float) -> Any:
    def change(array: Any) -> Any:
        array.flat[0] = value
        return array

    return change


def valid_nan(log: Any) -> Any:
    log.position[log.valid] = np.nan
    return log


@pytest.mark.parametrize(
    ("name", "change", "reason"),
    [
        ("log", valid_nan, "not-a-number"),
        ("vehicles.size", first_is(np.nan), "not-a-number"),
        ("vehicles.size", first_is(-4.5), "bad-vehicles"),
        ("vehicles.kind", first_is(255), "bad-vehicles"),
        ("vehicles.heading", lambda heading: heading[:-1], "bad-vehicles"),
        ("vehicles.position", lambda position: position[:-1], "bad-vehicles"),
        ("horizon", lambda _: -1, "bad-shard"),
        ("horizon", lambda _: 0, "bad-trajectories"),
        ("map.links", first_is(10_000), "bad-map"),
        ("map.yields_to", first_is(10_000), "bad-map"),
        ("map.kind", first_is(255), "bad-map"),
        ("map.speed_limit", first_is(-1), "bad-map"),
        ("map.centreline.start", first_is(3), "bad-map"),
        ("map.left.points", lambda points: points[:-3], "bad-map"),
        ("map.origin", first_is(np.inf), "bad-map"),
    ],
)
def test_a_sealed_shard_with_absurd_content_is_refused_by_name_and_row(
    tmp_path: Path, name: str, change: Any, reason: str
) -> None:
    write_shard(tmp_path / "s.parquet", [any_scenario(2), tampered(name, change)])
    with pytest.raises(UnusableInput, match=r"s\.parquet, row 1") as refusal:
        read_shard(tmp_path / "s.parquet")
    assert refusal.value.reason == reason
    assert "\n" not in str(refusal.value)


def without(path: Path, column: str) -> None:
    """The shard in `path` without a column, its checksum right."""
    table = pq.read_table(path)
    names = [name for name in table.column_names if name != column]
    write_shard_table(path, {name: table[name].combine_chunks() for name in names}, "scenarios", VERSION)


def test_a_shard_without_a_column_is_refused_by_name(tmp_path: Path) -> None:
    write_shard(tmp_path / "s.parquet", [any_scenario(2)])
    without(tmp_path / "s.parquet", "map.links")
    with pytest.raises(UnusableInput, match=r"s\.parquet, row 0, is no sound row \('map\.links'\)") as refusal:
        read_shard(tmp_path / "s.parquet")
    assert refusal.value.reason == "bad-shard"


def test_more_values_than_memory_holds_are_refused_before_they_are_read(good: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(safe_parquet, "MOST_VALUES", 100)
    with pytest.raises(UnusableInput, match=r"good\.parquet holds \d+ values, more than 100") as refusal:
        read_shard(good)
    assert refusal.value.reason == "too-large"
