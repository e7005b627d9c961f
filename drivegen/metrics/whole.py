"""What only a whole set of scenes has: means with intervals, diversity, distances, likelihoods, how far it can be told apart.

Names are flat, `x` with `x.low` and `x.high`: `summary` is what the details of a method's evaluation hold. Scenes of different
length are not taken together: means are over those of the length that most have, the others are counted.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.intervals import Interval, bootstrap_means, recording, usual_length
from drivegen.core.scenario import Trajectories
from drivegen.core.seeds import rng
from drivegen.metrics.classifier import TrackPairs, telling_apart
from drivegen.metrics.distributions import SceneCounts, distances
from drivegen.metrics.diversity import (
    OwnFrames,
    own_frames,
    plain_differences,
    random_pairs,
    ratio,
    squared_differences,
)
from drivegen.metrics.each import Each
from drivegen.metrics.joint import SceneJoint, joint_figures
from drivegen.metrics.proper import likeliest_for_others
from drivegen.metrics.scene import Scored, Settings

TOTALS = ("agent_steps", "vehicles")

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Scenes:
    """What was `Scored` of S scenes, a sequence a field: read when asked for, where it is kept in files."""

    scenario: Sequence[str]
    metrics: Sequence[dict[str, float]]
    samples: Sequence[dict[str, Floats]]
    log: Sequence[Trajectories]
    best: Sequence[Trajectories]
    any_sample: Sequence[Trajectories]
    counts: Sequence[SceneCounts]
    tracks: Sequence[TrackPairs]
    densities: Sequence[Floats]
    joint: Sequence[SceneJoint]

    @classmethod
    def of(cls, scored: Iterable[Scored], kept: Callable[[], Any] = list) -> Self:
        """Of all scenes, each field appended to what `kept` makes."""
        columns: dict[str, Any] = {field.name: kept() for field in fields(cls)}
        for scene in scored:
            for name, column in columns.items():
                column.append(getattr(scene, name))
        return cls(**columns)

    def __len__(self) -> int:
        return len(self.scenario)

    def take(self, rows: NDArray[np.intp]) -> "Scenes":
        """Those of these numbers."""

        def taken(column: Sequence[Any]) -> Sequence[Any]:
            return Each(len(rows), lambda number: column[int(rows[number])])

        return Scenes(**{field.name: taken(getattr(self, field.name)) for field in fields(self)})


def columns(scenes: Scenes, settings: Settings) -> dict[str, Floats]:
    """Every number of every scene by name, each (S,): NaN where a scene has none. Likelihoods are added to what scenes have."""
    names = sorted({name for metrics in scenes.metrics for name in metrics})
    numbers = np.stack([np.array([metrics.get(name, np.nan) for name in names]) for metrics in scenes.metrics])
    table = dict(zip(names, np.ascontiguousarray(numbers.T), strict=True))
    densities, recordings = np.stack(list(scenes.densities)), _recordings(scenes)
    for kind, prefix in enumerate(("nll", "nll_joint")):
        for h, horizon in enumerate(settings.horizons):
            value, chosen = likeliest_for_others(densities[:, kind, h], recordings)
            name = f"{prefix}_{horizon:g}s"
            table[name] = -value
            widths = np.array(settings.bandwidths)
            table[f"bandwidth.{name}"] = np.where(chosen >= 0, widths[chosen], np.nan)
    return table


def sample_columns(scenes: Scenes) -> tuple[list[str], NDArray[np.int64], dict[str, Floats]]:
    """Every sample's numbers: the scenario of each, its number there, and what was measured, each (K of all scenes,)."""
    counts = [len(samples["sade"]) for samples in scenes.samples]
    scenarios = [scenario for scenario, count in zip(scenes.scenario, counts, strict=True) for _ in range(count)]
    values = {name: np.concatenate([samples[name] for samples in scenes.samples]) for name in scenes.samples[0]}
    return scenarios, np.concatenate([np.arange(count) for count in counts]), values


def summary(scenes: Scenes, table: Mapping[str, Floats], seed: int, draws: int, splits: int) -> dict[str, float]:
    """Everything over the set, from its scenes and their `columns`; intervals resample recordings.

    `scenarios` of `recordings` with `steps` steps each are measured; `left_out.N` scenarios have N steps.
    """
    lengths = Counter(int(steps) for steps in table["steps"])
    usual = usual_length(table["steps"])
    kept = np.flatnonzero(table["steps"] == usual)
    scenes, table = scenes.take(kept), {name: column[kept] for name, column in table.items()}
    recordings = _recordings(scenes)
    numbers = _means(table, recordings, seed, draws) | _diversity(scenes, recordings, seed, draws, splits)
    apart = distances(scenes.counts, recordings, draws, _stream(seed, "distances"))
    found = {f"distance.{name}": interval for name, interval in apart.items()}
    found |= joint_figures(scenes.joint, recordings, draws, _stream(seed, "joint"))
    found["auc"] = telling_apart(scenes.tracks, recordings, seed, draws, _stream(seed, "classifier"))
    for name, interval in found.items():
        numbers |= _flat(name, interval)
    others = {f"left_out.{steps}": count for steps, count in sorted(lengths.items()) if steps != usual}
    return numbers | {"scenarios": len(scenes), "recordings": len(set(recordings)), "steps": usual} | others


def _recordings(scenes: Scenes) -> list[str]:
    return [recording(scenario) for scenario in scenes.scenario]


def _means(table: Mapping[str, Floats], recordings: Sequence[str], seed: int, draws: int) -> dict[str, float]:
    """Means over scenarios with their intervals; labels are counted, not averaged."""
    labels = {name for name in table if name.startswith(("label.", "manoeuvre."))}
    names = sorted(set(table) - labels - {*TOTALS, "steps"})
    values = np.stack([table[name] for name in names], axis=1)
    intervals = bootstrap_means(values, recordings, draws, _stream(seed, "bootstrap"))
    out = {name: float(np.nansum(table[name])) for name in sorted(labels)}
    for name, interval in zip(names, intervals, strict=True):
        out |= _flat(name, interval)
    return out | {name: float(table[name].sum()) for name in TOTALS}


def _diversity(scenes: Scenes, recordings: Sequence[str], seed: int, draws: int, splits: int) -> dict[str, float]:
    """Diversity of the log, the best sample and a random sample, and both ratios, by squared and by plain norm."""
    pairs = random_pairs(len(scenes), splits, _stream(seed, "pairs"))
    sets: dict[str, OwnFrames] = {
        "log": own_frames(scenes.log),
        "": own_frames(scenes.best),
        "any_sample": own_frames(scenes.any_sample),
    }
    out: dict[str, float] = {"diversity_pairs": len(pairs)}
    for norm, differences in {"": squared_differences, "plain": plain_differences}.items():
        values = {name: differences(frames, pairs) for name, frames in sets.items()}
        for name in sets:
            out[_joined("diversity", name, norm)] = float(values[name].mean()) if len(pairs) else np.nan
            if name != "log":
                stream = _stream(seed, "diversity", norm, name)
                found = ratio(values[name], values["log"], pairs, recordings, draws, stream)
                out |= _flat(_joined("diversity_ratio", name, norm), found)
    return out


def _stream(seed: int, *names: str) -> np.random.Generator:
    return rng(seed, "evaluate", *names)


def _joined(*words: str) -> str:
    return "_".join(word for word in words if word)


def _flat(name: str, interval: Interval) -> dict[str, float]:
    return {name: interval.value, f"{name}.low": interval.low, f"{name}.high": interval.high}
