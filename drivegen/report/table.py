"""Tables of text cells, for the page and for Markdown."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import floor, isfinite, log10
from typing import Any

NOT_MEASURED = "not measured"

NOTHING = 1e-9
"""What is nearer to 0 is written as 0: sums of equal numbers leave as much."""

_SHORT = 12
"""Rows that a reader takes in at once; the page folds longer tables."""

RESTORED = "not measured here: restored from cache"
"""The time of a stage whose results are there though it did not run here."""


@dataclass(frozen=True)
class Cell:
    """Text with a small note beside it (an interval) and whether it is the best of its column."""

    text: str
    note: str = ""
    best: bool = False


@dataclass(frozen=True)
class Row:
    """Cells under a heading; `origin` decides the look: "ours", "rival" (ours to measure), "paper" (its figures) or ""."""

    cells: tuple[Cell, ...]
    origin: str = ""


@dataclass(frozen=True)
class Table:
    """`name` is the file name in reports/tables, `columns` the headings, the first one of the row's names.

    A table that is not `repeatable` holds times, which differ from run to run: the report shows it in its page and writes no file
    of it. Published tables are files all the same, those of costs and models with the times of the runs that are published.
    `picture` is an SVG that a published table shows, beside it under the same name; empty where there is none.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = field(default=())
    repeatable: bool = True
    picture: bytes = b""

    @property
    def long(self) -> bool:
        """Whether the page shows it folded."""
        return len(self.rows) > _SHORT

    def markdown(self) -> str:
        """The table with its title and notes; cells' pipes are escaped."""
        lines = [f"### {self.title}", "", _line(self.columns), _line(["---"] + ["---:"] * (len(self.columns) - 1))]
        lines += [_line([_plain(cell) for cell in row.cells]) for row in self.rows]
        lines += ["", f"![{self.title}]({self.name}.svg)"] if self.picture else []
        lines += ["", *self.notes] if self.notes else []
        return "\n".join(lines) + "\n"


def _line(cells: "list[str] | tuple[str, ...]") -> str:
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"


def _plain(cell: Cell) -> str:
    text = f"**{cell.text}**" if cell.best else cell.text
    return f"{text} ({cell.note})" if cell.note else text


def row(*cells: "str | Cell", origin: str = "") -> Row:
    """A row of texts and cells."""
    return Row(tuple(cell if isinstance(cell, Cell) else Cell(cell) for cell in cells), origin)


def number(value: Any, digits: int = 2) -> str:
    """A number for reading: thousands apart, `digits` decimals for fractions; text stays, nothing is "not measured"."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f")
    if isinstance(value, float):
        if not isfinite(value):
            return NOT_MEASURED
        if value.is_integer() and abs(value) >= 10:
            return number(int(value))
        return f"{value:.{digits}f}" if abs(value) >= 10**-digits or value == 0 else f"{value:.2g}"
    return NOT_MEASURED if value is None else str(value)


def taken(took: Mapping[str, float], name: str, digits: int = 1) -> str:
    """A time out of what a stage took: RESTORED where the stage did not run here, "none" where it used no such processor."""
    if not took:
        return RESTORED
    return number(took[name], digits) if name in took else "none"


ENDS = ("value", "low", "high")


def estimate(line: Mapping[str, Any] | None, digits: int = 3, names: tuple[str, str, str] = ENDS) -> Cell:
    """A published figure of a line, by the `names` of value and ends, with its interval where it has one; "" without it."""
    value, low, high = (line[name] for name in names) if line is not None else (None,) * 3
    if value is None:
        return Cell("")
    return Cell(decimals(value, digits), _interval(low, high, digits, " to "))


def decimals(value: float, digits: int, sign: str = "") -> str:
    """A number with so many decimals; one that would read as 0 and is none has two significant digits, so it keeps its side."""
    if NOTHING < abs(value) < 0.5 * 10**-digits:
        return f"{value:{sign}.2g}"
    return f"{round(value, digits) + 0.0:{sign}.{digits}f}"  # adding 0 takes the sign of -0.0


def _interval(low: float | None, high: float | None, digits: int, between: str) -> str:
    """Both ends, "" where there are none; both are the value where no recording differs from the others (`core.intervals`)."""
    return "" if low is None or high is None or low == high else f"{decimals(low, digits)}{between}{decimals(high, digits)}"


def measured(values: dict[str, Any], key: str, digits: int = 2) -> Cell:
    """`values[key]` with its interval from `key.low` and `key.high`, where they are."""
    value, low, high = (values.get(f"{key}{end}") for end in ("", ".low", ".high"))
    if value is None or not isfinite(value):
        return Cell(NOT_MEASURED)
    if NOTHING < abs(value) < 10**-digits:
        digits = 1 - floor(log10(abs(value)))  # two significant ones, the ends as exact
    return Cell(decimals(value, digits), _interval(low, high, digits, " to " if low is not None and low < 0 else "\u2013"))
