"""Which shards still stand."""

from dataclasses import replace
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from drivegen.store.notes import ShardNote, arrange, digest, read_note, stands, write_note

NOTE = ShardNote(items=("a", "b"), settings="s", inputs="i", shard="h", outcome={"counts": {"x": 1}})


def noted(arranged: dict[int, tuple[str, ...]], settings: str = "s") -> dict[int, ShardNote]:
    return {number: ShardNote(items, settings, "i", "h", {}) for number, items in arranged.items()}


def test_a_note_comes_back_and_a_damaged_one_is_none(tmp_path: Path) -> None:
    path = tmp_path / "shard-00000.json"
    write_note(path, NOTE)
    assert read_note(path) == NOTE
    path.write_bytes(path.read_bytes()[:-9])
    assert read_note(path) is None
    assert read_note(tmp_path / "nowhere.json") is None


def test_a_shard_stands_only_with_the_same_settings_inputs_and_bytes(tmp_path: Path) -> None:
    shard = tmp_path / "shard.parquet"
    nothing = replace(NOTE, shard=digest([shard]))
    assert stands(nothing, "s", "i", shard)
    shard.write_bytes(b"abc")
    note = replace(NOTE, shard=digest([shard]))
    assert stands(note, "s", "i", shard)
    assert not stands(nothing, "s", "i", shard)
    assert not stands(note, "other", "i", shard)
    assert not stands(note, "s", "other", shard)
    assert not stands(None, "s", "i", shard)
    shard.write_bytes(b"abd")
    assert not stands(note, "s", "i", shard)


@given(st.sets(st.text("abc", max_size=3)), st.sets(st.text("abc", max_size=3)), st.integers(1, 5))
def test_every_wanted_item_is_in_one_shard_and_shards_that_can_stay_do(before: set[str], after: set[str], size: int) -> None:
    first = arrange(sorted(before), {}, "s", size)
    second = arrange(sorted(after), noted(first), "s", size)
    assert sorted(item for items in second.values() for item in items) == sorted(after)
    assert all(len(items) <= size for items in second.values())
    for number, items in first.items():
        if after.issuperset(items):
            assert second[number] == items


def test_other_settings_keep_nothing() -> None:
    first = arrange(["a", "b", "c"], {}, "s", 2)
    assert arrange(["c", "b", "a"], noted(first), "other", 2) == {0: ("c", "b"), 1: ("a",)}


def test_a_digest_is_of_bytes_not_of_order_or_time(tmp_path: Path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_text("1")
    two.write_text("2")
    before = digest([one, two])
    assert digest([two, one, two]) == before
    one.touch()
    assert digest([one, two]) == before
    one.write_text("3")
    assert digest([one, two]) != before
    assert digest([one]) != digest([one, tmp_path / "absent"])
