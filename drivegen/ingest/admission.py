"""Recordings become scenarios or are rejected: every one is accounted for, by data set, with a countable reason."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pyarrow as pa

from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.scenario import Scenario, SizeSource
from drivegen.datasets.base import Dataset
from drivegen.ingest.selection import Settings, select


@dataclass
class Admission:
    """What became of recordings.

    Attributes:
        counts: numbers by data set: accepted, rejected, rejected.<reason>, noted.<what was adapted>, scored agent-steps...
        rejected: (data set, scene, reason, sentence) of each rejected one, in order.
    """

    counts: dict[str, Counter[str]] = field(default_factory=dict)
    rejected: list[tuple[str, ...]] = field(default_factory=list)

    def admit(self, data: Dataset, split: str, scene: str, settings: Settings) -> Scenario | None:
        """The scenario of one recording, or None if it is rejected; counted either way."""
        counts = self.counts.setdefault(data.description, Counter())
        try:
            log = data.read(split, scene)
            scenario = select(log, settings)
        except UnusableInput as error:
            self.reject(data, scene, error)
            return None
        counts.update(_numbers(log, scenario, settings))
        return scenario

    def reject(self, data: Dataset, scene: str, why: UnusableInput) -> None:
        """Count a recording that cannot be used."""
        self.counts.setdefault(data.description, Counter()).update(["rejected", f"rejected.{why.reason}"])
        self.rejected.append((data.description, scene, why.reason, str(why)))

    def add(self, other: "Admission") -> None:
        """Count another one's recordings too."""
        for name, numbers in other.counts.items():
            self.counts.setdefault(name, Counter()).update(numbers)
        self.rejected += other.rejected

    @property
    def accepted(self) -> int:
        """Scenarios over all data sets."""
        return sum(counts["accepted"] for counts in self.counts.values())

    def as_tree(self) -> dict[str, Any]:
        """Plain JSON."""
        return {"counts": {name: dict(numbers) for name, numbers in self.counts.items()}, "rejected": self.rejected}

    @classmethod
    def of_tree(cls, tree: dict[str, Any]) -> "Admission":
        """The inverse of `as_tree`."""
        counts = {name: Counter(numbers) for name, numbers in tree["counts"].items()}
        return cls(counts, [tuple(row) for row in tree["rejected"]])


def seen_for_half(scenario: Scenario) -> int:
    """How many vehicles were recorded for half of the scenario or longer: these are worth learning from."""
    return 0 if scenario.log is None else int(np.count_nonzero(scenario.log.valid.mean(-1) >= 0.5))


def usable_tracks(data: Dataset, settings: Settings, enough: int) -> int:
    """Vehicles seen for half of their scenario in the training split; counting stops when there are `enough`."""
    tracks, ignored = 0, Admission()
    for scene in data.scenes("train"):
        scenario = ignored.admit(data, "train", scene, settings)
        tracks += 0 if scenario is None else seen_for_half(scenario)
        if tracks >= enough:
            break
    return tracks


def _numbers(log: RecordedLog, scenario: Scenario, settings: Settings) -> Counter[str]:
    """Numbers of one accepted scenario, to be summed."""
    counts = Counter(accepted=1, vehicles=len(scenario.vehicles), context_actors=len(scenario.context))
    counts["signals"] = len(scenario.signals)
    counts["dangling_lane_links"] = scenario.map.dangling
    counts["shorter_horizon"] = int(scenario.horizon < settings.horizon)
    counts["vehicles_seen_for_half"] = seen_for_half(scenario)
    if scenario.log is not None:
        counts["scored_agent_steps"] = int(scenario.log.valid[:, 1:].sum())
    for source in SizeSource:
        counts[f"sizes.{source.name.lower()}"] = int((scenario.vehicles.size_source == source).sum())
    for name, value in scenario.notes.items():
        counts[f"noted.{name}"] = int(value) if value.isdecimal() else 1
    for word, tracks in log.skipped.items():
        counts[f"skipped_tracks.{word}"] = tracks
    return counts


def require_scenarios(admissions: Mapping[str, Admission], remedy: str) -> None:
    """Raise UnusableInput, with the reasons and the remedy, where no recording was accepted to train on or to measure on."""
    for split in ("train", "test"):
        if not admissions[split].accepted:
            reasons = count_reasons(admissions[split].rejected) or "there are none"
            raise UnusableInput(f"no scene can be used as {split} scenario ({reasons}); {remedy}")


def count_reasons(rejected: Sequence[tuple[str, ...]]) -> str:
    """The most frequent reasons of rows as in `Admission.rejected`, in words; "" without rows."""
    return ", ".join(f"{count} x {reason}" for reason, count in Counter(row[2] for row in rejected).most_common(5))


def accounts(total: Mapping[str, Admission]) -> dict[str, pa.Table]:
    """By split: `rejected`, a row a recording with its reason, and `counts`, a row a number."""
    words = pa.string()
    rejected = [(split, *row) for split, admission in total.items() for row in admission.rejected]
    numbers = [
        (split, source, name, count)
        for split, admission in total.items()
        for source, counts in sorted(admission.counts.items())
        for name, count in sorted(counts.items())
    ]
    return {
        "rejected": _table(rejected, dict.fromkeys(("split", "source", "scene", "reason", "sentence"), words)),
        "counts": _table(numbers, {"split": words, "source": words, "name": words, "count": pa.int64()}),
    }


def _table(rows: Sequence[tuple[Any, ...]], columns: Mapping[str, pa.DataType]) -> pa.Table:
    return pa.table({name: pa.array([row[i] for row in rows], kind) for i, (name, kind) in enumerate(columns.items())})
