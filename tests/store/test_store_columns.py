"""Tables end to end: the same in memory and mapped, numbers that count through other columns raised, short rows continued."""

import tracemalloc
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
from numpy.typing import NDArray

from drivegen.store.columns import Columns, Filed, Held, Rows, Starts, joined, mapped


@dataclass(frozen=True)
class Lights:
    """Rows of different lengths; the last one stays."""

    state: Annotated[NDArray[np.uint8], Held()]

    @classmethod
    def none(cls) -> "Lights":
        return cls(np.zeros((0, 1), np.uint8))


@dataclass(frozen=True)
class Roads:
    """Scenes of pieces, each guarded by one of the posts or none; moved by so much at each step."""

    start: Annotated[NDArray[np.int64], Starts("piece")]
    piece: NDArray[np.float32]
    guard: Annotated[NDArray[np.int32], Rows("post")]
    post: NDArray[np.bool_]
    moved: NDArray[np.float64]
    lights: Lights

    @classmethod
    def none(cls) -> "Roads":
        count = np.zeros(0, np.int32)
        return cls(np.zeros(1, np.int64), np.zeros((0, 2), np.float32), count, count > 0, np.zeros((0, 1, 2)), Lights.none())


def roads(scenes: int, steps: int, seed: int) -> Roads:
    random = np.random.default_rng(seed)
    start = np.concatenate([[0], random.integers(0, 4, scenes).cumsum()])
    guard = random.integers(-1, 3, start[-1]).astype(np.int32)
    piece, moved = random.random((start[-1], 2)).astype(np.float32), random.random((scenes, steps, 2))
    lights = random.integers(0, 9, (scenes, steps)).astype(np.uint8)
    return Roads(start, piece, guard, random.random(3) < 0.5, moved, Lights(lights))


PARTS = [roads(3, 4, 0), Roads.none(), roads(2, 6, 1), roads(4, 5, 2)]


@pytest.fixture(params=["memory", "files"])
def folder(request: pytest.FixtureRequest, tmp_path: Path) -> Path | None:
    return tmp_path / "new" if request.param == "files" else None


def test_each_scene_keeps_its_own_pieces_guards_and_steps(folder: Path | None) -> None:
    whole = joined(Roads, PARTS, folder)
    assert whole.moved.shape == (9, 6, 2)
    scene = 0
    for part in PARTS:
        for own in range(len(part.start) - 1):
            mine, theirs = (slice(*t.start[i : i + 2]) for t, i in ((part, own), (whole, scene)))
            np.testing.assert_array_equal(whole.piece[theirs], part.piece[mine])
            guards, before = whole.guard[theirs], part.guard[mine]
            np.testing.assert_array_equal(guards < 0, before < 0)
            np.testing.assert_array_equal(whole.post[guards[guards >= 0]], part.post[before[before >= 0]])
            steps = part.moved.shape[1]
            np.testing.assert_array_equal(whole.moved[scene, :steps], part.moved[own])
            assert not whole.moved[scene, steps:].any()
            np.testing.assert_array_equal(whole.lights.state[scene, :steps], part.lights.state[own])
            assert (whole.lights.state[scene, steps:] == part.lights.state[own, -1]).all()
            scene += 1
    assert scene == 9


def test_mapped_and_in_memory_are_the_same_bytes_and_no_file_is_left(tmp_path: Path) -> None:
    one, other = joined(Roads, PARTS), joined(Roads, PARTS, tmp_path)
    for name in ("start", "piece", "guard", "post", "moved"):
        mine, theirs = getattr(one, name), getattr(other, name)
        assert (mine.dtype, mine.shape, mine.tobytes()) == (theirs.dtype, theirs.shape, theirs.tobytes())
    assert list(tmp_path.iterdir()) == []


def test_no_part_is_a_table_without_rows(folder: Path | None) -> None:
    empty = joined(Roads, [], folder)
    assert (len(empty.start), empty.piece.shape, empty.lights.state.shape) == (1, (0, 2), (0, 1))


def test_a_mapped_array_is_filled_by_whoever_asked_for_it(tmp_path: Path) -> None:
    array = mapped(tmp_path, (3, 2), np.float32)
    assert array.tolist() == [[0, 0]] * 3
    array[1] = 5
    assert array.sum() == 10
    assert mapped(tmp_path, (0, 2), np.int64).shape == (0, 2)


def test_memory_does_not_grow_with_the_parts(tmp_path: Path) -> None:
    def parts(count: int) -> Iterator[Roads]:
        return (roads(200, 100, seed) for seed in range(count))

    def peak(count: int) -> int:
        tracemalloc.start()
        table = joined(Roads, parts(count), tmp_path)
        rows = np.arange(0, len(table.moved), 50)
        table.moved[rows].sum()
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most

    Columns(Roads, tmp_path).whole()
    one = roads(200, 100, 0).moved.nbytes
    assert peak(40) - peak(10) < one  # thirty parts more, and less than one of them


def test_filed_values_are_read_one_by_one_in_any_order(tmp_path: Path) -> None:
    filed = Filed(tmp_path)
    values = [{"a": np.arange(n, dtype=np.float32), "b": [None, n]} for n in range(4)]
    for value in values[:3]:
        filed.append(value)
    assert filed[2]["a"].tolist() == [0, 1]
    filed.append(values[3])
    assert len(filed) == 4
    for found, value in zip([filed[3], *filed], [values[3], *values], strict=True):
        assert found["b"] == value["b"]
        np.testing.assert_array_equal(found["a"], value["a"])
    with pytest.raises(IndexError):
        filed[4]
    assert list(tmp_path.iterdir()) == []


def test_filed_values_take_no_memory(tmp_path: Path) -> None:
    tracemalloc.start()
    filed = Filed(tmp_path)
    for _ in range(100):
        filed.append(np.ones(100_000))
    assert sum(value.sum() for value in filed) == 1e7
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 5 * 800_000  # of 80 MB
