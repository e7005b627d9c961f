"""Plots as SVG with the same bytes for the same numbers; matplotlib without pyplot and without a display."""

import io
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

INK, FAINT, OURS, THEIRS, LOG = "#1f2733", "#d7dce3", "#ea6914", "#7d8aa0", "#1f2733"
SERIES = ("#ea6914", "#2570c4", "#7c42d6", "#26a65b", "#d62846", "#8a6d3b", "#0f8b8d", "#555b66")

Thing = TypeVar("Thing")

Series = Mapping[str, tuple[Sequence[float], Sequence[float]]]
"""Named lines (x, y)."""

_STYLE = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#eceff3",
    "axes.axisbelow": True,
    "svg.hashsalt": "drivegen",
    "svg.fonttype": "path",
}


class Canvas:
    """A figure with one set of axes: `with Canvas(6, 3) as (canvas, axes): ...; canvas.svg`; `canvas.axes` are all of them."""

    def __init__(self, width: float, height: float, rows: int = 1, columns: int = 1) -> None:
        self._size, self._grid = (width, height), (rows, columns)
        self.svg = b""

    def __enter__(self) -> tuple["Canvas", Axes]:
        self._style = mpl.rc_context(_STYLE)
        self._style.__enter__()
        self._figure = Figure(figsize=self._size, layout="constrained")
        FigureCanvasSVG(self._figure)
        self.axes: list[Axes] = list(self._figure.subplots(*self._grid, squeeze=False).flat)
        return self, self.axes[0]

    def __exit__(self, *failure: object) -> None:
        if failure[0] is None:
            buffer = io.BytesIO()
            self._figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
            self.svg = buffer.getvalue()
        self._style.__exit__(None, None, None)


def coloured(things: Collection[Thing], colours: Sequence[str] = SERIES) -> Iterator[tuple[Thing, str]]:
    """Each thing with a colour, none left out: where there are more things than colours these come again from the first."""
    for n, thing in enumerate(things):
        yield thing, colours[n % len(colours)]


def realism_against_diversity(ours: Mapping[str, tuple[float, float]], theirs: Mapping[str, tuple[float, float]]) -> bytes:
    """(diversity ratio, min-sADE) of each method; right in the middle and low is good."""
    with Canvas(5.6, 3.6) as (canvas, axes):
        axes.axvline(1.0, color=FAINT, lw=1.2, zorder=0)
        kinds = ((theirs, THEIRS, "o"), (ours, OURS, "D"))
        for points, colour, marker in kinds:
            for x, y in points.values():
                axes.scatter([x], [y], s=42, color=colour, marker=marker, zorder=3, edgecolor="white", linewidth=0.8)
        axes.set_xlabel("diversity ratio (1 = as diverse as the real set)")
        axes.set_ylabel("min-sADE [m]")
        axes.set_ylim(bottom=0)
        axes.margins(x=0.2)
        places = [place for points, _, _ in kinds for place in points.values()]
        labels = [(name, colour) for points, colour, _ in kinds for name in points]
        spans = [np.ptp(limits) for limits in (axes.get_xlim(), axes.get_ylim())]
        for (x, _), (name, colour), y in zip(places, labels, apart(places, 0.27 * spans[0], 0.047 * spans[1]), strict=True):
            axes.annotate(name, (x, y), xytext=(6, 0), textcoords="offset points", fontsize=7.5, color=colour, va="center")
    return canvas.svg


def front(curve: Sequence[tuple[str, float, float]], points: Mapping[str, tuple[float, float]]) -> bytes:
    """A curve of labelled (label, x, y) beside named points (x, y): diversity ratio across, mean-sADE up."""
    with Canvas(6.8, 3.6) as (canvas, axes):
        axes.axvline(1.0, color=FAINT, lw=1.2, zorder=0)
        if curve:
            labels, xs, ys = zip(*curve, strict=True)
            axes.plot(xs, ys, color=OURS, lw=1.4, marker="D", ms=5, zorder=3, label="DriveGen, by temperature")
            for n, place in enumerate(zip(labels, xs, ys, strict=True)):
                away = (0, (-9, 9)[n % 2])
                axes.annotate(
                    place[0], place[1:], away, textcoords="offset points", fontsize=7.5, color=OURS, ha="center", va="center"
                )
        for (name, (x, y)), colour in coloured(points.items(), SERIES[1:]):
            axes.scatter([x], [y], s=42, color=colour, zorder=2, edgecolor="white", linewidth=0.8, label=name)
        axes.set_xlabel("diversity ratio (1 = as diverse as the real set)")
        axes.set_ylabel("mean-sADE [m]")
        axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return canvas.svg


def apart(places: Sequence[tuple[float, float]], near: float, line: float) -> list[float]:
    """Heights of labels at `places` (x, y), raised until those within `near` of one another in x are a `line` apart."""
    height: dict[int, float] = {}
    for at in sorted(range(len(places)), key=lambda i: places[i][1]):
        x, y = places[at]
        for below in sorted(h for other, h in height.items() if abs(places[other][0] - x) < near):
            y = max(y, below + line) if y > below - line else y
        height[at] = y
    return [height[i] for i in range(len(places))]


def curves(columns: Mapping[str, Sequence[float]], over: str) -> bytes:
    """Lines of every column over the column `over`; on a logarithmic axis where values span two decades."""
    with Canvas(5.6, 2.8) as (canvas, axes):
        names = [name for name in columns if name != over]
        for name, colour in coloured(names):
            points = [(x, y) for x, y in zip(columns[over], columns[name], strict=True) if y == y]
            if points:
                axes.plot(*zip(*points, strict=True), color=colour, lw=1.4, label=name.replace("_", " "))
        positive = [y for name in names for y in columns[name] if y == y]
        if positive and min(positive) > 0 and max(positive) / min(positive) > 100:
            axes.set_yscale("log")
        axes.set_xlabel(over.replace("_", " "))
        if len(names) > 1:
            axes.legend(frameon=False, fontsize=8)
        else:
            axes.set_ylabel(names[0].replace("_", " ") if names else "")
    return canvas.svg


def panels(
    series: Mapping[str, Mapping[str, tuple[Sequence[float], Sequence[float]]]],
    across: str,
    up: str,
    columns: int = 4,
    colours: Sequence[str] = SERIES,
) -> bytes:
    """Named lines (x, y) in a small plot for each group, `columns` side by side; scales differ, lines' colours do not.

    The first plot's legend has the lines that are in it, a later one's those that none before it has.
    """
    rows = -(-len(series) // columns)
    colour_of = dict(coloured(list(dict.fromkeys(name for group in series.values() for name in group)), colours))
    named: set[str] = set()
    with Canvas(2.9 * columns, 2.0 * max(rows, 1), max(rows, 1), columns) as (canvas, _):
        for axes in canvas.axes[len(series) :]:
            axes.set_visible(False)
        for n, (axes, (title, group)) in enumerate(zip(canvas.axes[: len(series)], series.items(), strict=True)):
            axes.set_title(title, fontsize=9)
            for name, (xs, ys) in group.items():
                axes.plot(xs, ys, color=colour_of[name], lw=1.2, label="" if name in named else name)
            axes.set_xlabel(across)
            axes.set_ylabel(up if n % columns == 0 else "")
            if not named.issuperset(group):
                axes.legend(frameon=False, fontsize=7)
            named |= set(group)
    return canvas.svg


def bars(groups: Mapping[str, float], label: str, errors: Mapping[str, tuple[float, float]] | None = None) -> bytes:
    """Horizontal bars, the first on top, with intervals where `errors` has (low, high)."""
    names = list(groups)
    with Canvas(5.6, 0.7 + 0.3 * len(names)) as (canvas, axes):
        values = [groups[name] for name in names]
        spread = None
        if errors is not None:
            ends = [errors.get(name, (groups[name], groups[name])) for name in names]
            pairs = list(zip(values, ends, strict=True))
            spread = [[max(v - low, 0) for v, (low, _) in pairs], [max(high - v, 0) for v, (_, high) in pairs]]
        style = {"ecolor": INK, "elinewidth": 1, "capsize": 2}
        axes.barh(range(len(names)), values, xerr=spread, color=SERIES[1], height=0.62, error_kw=style)
        axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set_xlabel(label)
    return canvas.svg


def shares(series: Mapping[str, Sequence[float]], label: str) -> bytes:
    """Cumulative shares: each series holds quantiles at evenly spaced shares from 0 to 1; the first is drawn as the log's."""
    with Canvas(5.6, 2.8) as (canvas, axes):
        for (name, quantiles), colour in coloured(series.items(), (LOG, *SERIES)):
            steps = len(quantiles) - 1
            axes.plot(quantiles, [i / max(steps, 1) for i in range(len(quantiles))], color=colour, lw=1.5, label=name)
        axes.set_xlabel(label)
        axes.set_ylabel("share of vehicles")
        axes.set_ylim(0, 1)
        axes.legend(frameon=False, fontsize=8)
    return canvas.svg


def lines(series: Mapping[str, tuple[Sequence[float], Sequence[float]]], across: str, up: str) -> bytes:
    """Named lines (x, y) of their own places, both axes from zero; NaNs are left out."""
    with Canvas(5.6, 2.8) as (canvas, axes):
        for (name, (xs, ys)), colour in coloured(series.items()):
            points = [(x, y) for x, y in zip(xs, ys, strict=True) if y == y]
            if points:
                axes.plot(*zip(*points, strict=True), color=colour, lw=1.4, marker="o", ms=3, label=name.replace("_", " "))
        axes.set_xlabel(across)
        axes.set_ylabel(up)
        axes.set_xlim(left=0)
        axes.set_ylim(bottom=0)
        if series:
            axes.legend(frameon=False, fontsize=8)
    return canvas.svg


def two_kinds(solid: Series, dashed: Series, across: str, up: str) -> bytes:
    """Named lines (x, y) of two kinds of things, each kind with all colours; x on a logarithmic axis, y are shares."""
    with Canvas(6.8, 3.6) as (canvas, axes):
        for series, style in ((solid, "-"), (dashed, "--")):
            for (name, (xs, ys)), colour in coloured(series.items()):
                axes.plot(xs, ys, color=colour, lw=1.4, ls=style, marker="o", ms=3, label=name)
        axes.set_xscale("log")
        axes.set_xlabel(across)
        axes.set_ylabel(up)
        axes.set_ylim(0, 1)
        if solid or dashed:
            axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return canvas.svg


def steps(series: Mapping[str, Mapping[str, tuple[float, float, float]]], across: str, up: str) -> bytes:
    """Lines over named steps, evenly spaced in the order of their first mention: value with its interval (value, low, high)."""
    places = {step: n for n, step in enumerate(dict.fromkeys(step for line in series.values() for step in line))}
    with Canvas(5.6, 3.2) as (canvas, axes):
        for n, ((name, line), colour) in enumerate(coloured(series.items())):
            xs = [
                places[step] + 0.06 * (n - (len(series) - 1) / 2) for step in line
            ]  # aside, so that intervals do not hide others
            values, lows, highs = (list(column) for column in zip(*line.values(), strict=True)) if line else ([], [], [])
            ends = [
                [max(v - low, 0) for v, low in zip(values, lows, strict=True)],
                [max(h - v, 0) for v, h in zip(values, highs, strict=True)],
            ]
            axes.errorbar(xs, values, yerr=ends, color=colour, lw=1.4, marker="o", ms=4, capsize=3, elinewidth=1, label=name)
        axes.set_xticks(range(len(places)), list(places))
        axes.set_xlabel(across)
        axes.set_ylabel(up)
        axes.set_ylim(bottom=0)
        if series:
            axes.legend(frameon=False, fontsize=8)
    return canvas.svg
