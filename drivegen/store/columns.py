"""Tables of many parts, end to end: in memory, or mapped from files of which no part stays in memory; and values in a file.

A table is a dataclass of arrays and of further tables; `none()` is one without rows. Parts are concatenated along the first
axis. Columns that count through another one say so in their type:

    start: Annotated[NDArray[np.int64], Starts("points")]

Mapped files have no name: the system removes them as soon as nobody uses them, also where a process is killed.
"""

import os
import pickle
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile
from typing import Annotated, Any, Generic, Protocol, Self, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Starts:
    """Marks a column (S + 1,): where each of S parts of the column `of` begins, and its length at the end."""

    of: str


@dataclass(frozen=True)
class Rows:
    """Marks a column of row numbers of the column `of`, negative where there is none."""

    of: str


@dataclass(frozen=True)
class Held:
    """Marks a column whose rows (T, ...) go on with their last value where other parts are longer; others go on with zeros."""


class Table(Protocol):
    """A frozen dataclass as the module says."""

    @classmethod
    def none(cls) -> Self:
        """No rows, of the right types and widths."""


T = TypeVar("T", bound=Table)
Anything = TypeVar("Anything")


def joined(kind: type[T], parts: Iterable[T], folder: Path | None = None) -> T:
    """All parts in order; in mapped files of `folder` where one is named."""
    columns = Columns(kind, folder)
    for part in parts:
        columns.add(part)
    return columns.whole()


def mapped(folder: Path | None, shape: tuple[int, ...], kind: Any) -> NDArray[Any]:
    """Zeros for whoever fills them, in a file of `folder` where one is named."""
    if folder is None:
        return np.zeros(shape, kind)
    with TemporaryFile(dir=folder) as file:
        file.truncate(int(np.prod(shape)) * np.dtype(kind).itemsize)
        return _map(file, shape, np.dtype(kind))


class Filed(Sequence[Anything]):
    """Values in a file of `folder`, whatever they are made of: each is read when it is asked for, and none stays in memory."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._file = TemporaryFile(dir=folder)  # noqa: SIM115 it lasts as long as this does
        self._ends = array("Q", [0])

    def append(self, value: Anything) -> None:
        """Add a value at the end."""
        self._ends.append(self._ends[-1] + self._file.write(pickle.dumps(value, protocol=5)))

    def __len__(self) -> int:
        return len(self._ends) - 1

    def __getitem__(self, number: Any) -> Any:
        """The value of that number, from 0 on."""
        begin, end = (self._ends[i] for i in (range(len(self))[number], number + 1))
        self._file.flush()
        return pickle.loads(os.pread(self._file.fileno(), end - begin, begin))  # noqa: S301 our own file

    def __del__(self) -> None:
        self._file.close()


class Columns(Generic[T]):
    """A table under way: its columns and the tables in it."""

    def __init__(self, kind: type[T], folder: Path | None = None) -> None:
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
        self._kind, self._marks, none = kind, _marks(kind), kind.none()
        self._columns, self._tables = dict[str, _Column](), dict[str, Columns[Any]]()
        for name in (field.name for field in fields(kind)):  # type: ignore[arg-type]  # a table is a dataclass
            value = getattr(none, name)
            if isinstance(value, np.ndarray):
                self._columns[name] = _Column(value, folder, isinstance(self._marks.get(name), Held))
            else:
                self._tables[name] = Columns(type(value), folder)
        self.add(none)

    def add(self, part: T) -> None:
        """Append the rows of `part`."""
        before = {name: column.rows for name, column in self._columns.items()}
        for name, column in self._columns.items():
            values = getattr(part, name)
            match self._marks.get(name):
                case Starts(of):
                    values = values[min(column.rows, 1) :] + before[of]  # one end is the next one's beginning
                case Rows(of):
                    values = np.where(values < 0, values, values + before[of])
            column.add(values)
        for name, table in self._tables.items():
            table.add(getattr(part, name))

    def whole(self) -> T:
        """The table; nothing can be added to it after that."""
        made: dict[str, Any] = {**self._columns, **self._tables}
        return self._kind(**{name: part.whole() for name, part in made.items()})


@cache
def _marks(kind: type[Any]) -> dict[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {name: get_args(hint)[1] for name, hint in hints.items() if get_origin(hint) is Annotated}


class _Column:
    """One array under way: its parts in a list, or end to end in a file, each as wide as it came."""

    def __init__(self, like: NDArray[Any], folder: Path | None, held: bool) -> None:
        self.rows, self._kind, self._folder, self._held = 0, like.dtype, folder, held
        self._shapes, self._parts = [like.shape], list[NDArray[Any]]()
        self._file = None if folder is None else TemporaryFile(dir=folder)  # noqa: SIM115 see `__del__`

    def __del__(self) -> None:
        if self._file is not None:
            self._file.close()  # also where nobody got as far as `whole`

    def add(self, values: NDArray[Any]) -> None:
        values = np.ascontiguousarray(values, self._kind)
        self._shapes.append(values.shape)
        self.rows += len(values)
        if self._file is None:
            self._parts.append(values)
        else:
            self._file.write(values.data)

    def whole(self) -> NDArray[Any]:
        """All rows, as wide as the widest part."""
        widths = [shape[1:] for shape in self._shapes if shape[0]] or [shape[1:] for shape in self._shapes]
        row = tuple(np.max(widths, axis=0).astype(int).tolist())
        if self._file is None:
            return np.concatenate([np.zeros((0, *row), self._kind), *(self._as_wide(part, row) for part in self._parts)])
        if all(shape[1:] == row for shape in self._shapes if shape[0]):
            return _map(self._file, (self.rows, *row), self._kind)
        self._file.seek(0)
        with TemporaryFile(dir=self._folder) as wide:
            for shape in self._shapes:
                part = np.fromfile(self._file, self._kind, int(np.prod(shape))).reshape(shape)
                wide.write(self._as_wide(part, row).data)
            return _map(wide, (self.rows, *row), self._kind)

    def _as_wide(self, part: NDArray[Any], row: tuple[int, ...]) -> NDArray[Any]:
        missing = [(0, 0), *((0, wanted - has) for wanted, has in zip(row, part.shape[1:], strict=True))]
        return np.pad(part, missing, mode="edge" if self._held else "constant") if len(part) else part.reshape(0, *row)


def _map(file: Any, shape: tuple[int, ...], kind: np.dtype[Any]) -> NDArray[Any]:
    """The file's content; may be written to, for torch and numba mind read-only arrays."""
    file.flush()
    return np.memmap(file, kind, "r+", shape=shape).view(np.ndarray) if np.prod(shape) else np.zeros(shape, kind)
