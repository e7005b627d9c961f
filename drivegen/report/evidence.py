"""What a report is made of: everything that the stages measured, as plain values. Any part may be missing."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from drivegen.core.methods import BOUND, Method


@dataclass(frozen=True)
class Picture:
    """A PNG with its caption and a title above it; `recording` is the relative path of one that shows the same, "" if none."""

    title: str
    caption: str
    png: bytes
    recording: str = ""


@dataclass(frozen=True)
class Link:
    """A file beside the page, by its relative path."""

    text: str
    href: str


@dataclass(frozen=True)
class Curve:
    """A training curve: named columns of numbers over a first column (step or epoch)."""

    title: str
    columns: Mapping[str, list[float]]


@dataclass(frozen=True)
class Evidence:
    """All that was found.

    Attributes:
        results: contents of the JSON files below reports/metrics, by path without suffix, e.g. "quality/drivegen".
        source: the data set in words, as in every scenario; "" if there is none yet.
        methods: what every generator says of itself, in the tables' order. selectors, planners: names, likewise.
        samples: futures of each scenario by every method; None if unknown.
        scenes: pictures of scenarios drawn by seed. comparisons: the same scenes by every method.
        maps: pictures of generated maps. collisions: pictures of the driver's collisions, the last round's first.
        curves: training curves. recordings: links to .rrd files.
        costs: what stages took, by "stage/item", then by name; they differ from run to run.
        provenance: names and hashes that say what the numbers were made from.
    """

    results: Mapping[str, Any] = field(default_factory=dict)
    source: str = ""
    methods: Mapping[str, Method] = field(default_factory=dict)
    selectors: tuple[str, ...] = ()
    planners: tuple[str, ...] = ()
    samples: int | None = None
    scenes: tuple[Picture, ...] = ()
    comparisons: tuple[Picture, ...] = ()
    maps: tuple[Picture, ...] = ()
    collisions: tuple[Picture, ...] = ()
    curves: tuple[Curve, ...] = ()
    costs: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    recordings: tuple[Link, ...] = ()
    provenance: Mapping[str, str] = field(default_factory=dict)

    def below(self, folder: str) -> dict[str, Any]:
        """Results whose path begins with `folder/`, by the rest of it, sorted."""
        prefix = folder + "/"
        return {path.removeprefix(prefix): value for path, value in sorted(self.results.items()) if path.startswith(prefix)}

    def title(self, method: str) -> str:
        """A method in words; results of a generator that is gone stand under its plain name."""
        return self.methods[method].title if method in self.methods else method.replace("_", " ")

    def origin(self, method: str) -> str:
        """The look of a method's row: "ours" or "rival"."""
        return "ours" if method in self.methods and self.methods[method].ours else "rival"

    def ordered(self, measured: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
        """Values by method in the tables' order; those of generators that are gone come last."""
        names = [name for name in self.methods if name in measured]
        return {name: dict(measured[name]) for name in [*names, *sorted(set(measured) - set(self.methods))]}

    def rows(self, measured: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
        """The same with an empty row for every method that was not measured but bounds and those whose selector did not run."""
        chosen = {None, *self.below("goals")}
        missing: dict[str, Any] = {
            name: {} for name, method in self.methods.items() if method.kind != BOUND and method.goals in chosen
        }
        return self.ordered(missing | dict(measured))

    @property
    def trained_on(self) -> tuple[str, ...]:
        """A note on what models were trained on, none if unknown: every table of ours carries it."""
        ingest = self.results.get("ingest")
        if not isinstance(ingest, Mapping) or not ingest.get("trained_on"):
            return ()
        return (words_of_training(ingest),)


def words_of_training(ingest: Mapping[str, Any]) -> str:
    """What the results of the stage ingest say about what models were trained on, with its note, in sentences."""
    sentences = [f"Models were trained on: {ingest['trained_on']}", str(ingest.get("note") or "")]
    return " ".join(f"{sentence.rstrip('.')}." for sentence in sentences if sentence)
