"""What is published: every method on every data set, over scenes and training seeds, as intervals and as rows."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.metrics.intervals import Interval, recording
from drivegen.metrics.pooled import Resampling, envelope, pooled_mean
from drivegen.scenario import Scenario

Floats = NDArray[np.float64]

FIVE = ("min_sade", "min_sfde", "mean_sade", "mean_sfde", "diversity")
"""The paper's columns."""

METHODS = {
    "drivegen": "DriveGen",
    "drivegen_vlm": "DriveGen, goals by a vision-language model",
    "drivegen_without_goals": "DriveGen w/o gs",
    "scene_transformer": "SceneTransformer",
    "bits": "BITS",
    "trafficgen": "TrafficGen",
    "lctgen": "LCTGen",
    "idm": "IDM",
    "constant_velocity": "Constant velocity",
    "random_agent": "Random agent",
    "log": "Log (recorded futures)",
}
"""All rows of every table; one that nobody ran reads "not measured"."""

RIVALS = ("scene_transformer", "bits", "trafficgen", "lctgen")
_FLOOR = "constant_velocity"
_JOINT = ("joint.order", "shuffled.order", "shuffled.headway", "shuffled.post_encroachment")
_OF_SETS = {"diversity_ratio": "diversity", "auc": "auc", **{name: name for name in _JOINT}}
"""Names in the details of an evaluation, and here: what only a whole set of scenes has. `distance.*` keep their names."""

_COUNTS = ("steps", "agent_steps", "vehicles", "bandwidth.", "manoeuvre.", "label.")
"""What evaluation counts on the way to its metrics: says how much was measured, not how well anybody did."""


@dataclass(frozen=True)
class Results:
    """One method on one data set.

    Attributes:
        scenarios: ids of N scenes. values: (S, N) by metric, one row a training seed, NaN where there is none.
        sets: an interval a seed, by the name of what only a whole set has.
        chosen_by: who chose goals, in words.
    """

    scenarios: tuple[str, ...]
    values: Mapping[str, Floats]
    sets: Mapping[str, list[Interval]]
    chosen_by: str


@dataclass(frozen=True)
class DataSet:
    """All methods on one data set.

    Attributes:
        name, title: in the JSON, and in words. trained_on: what models were trained on, in words.
        seeds: of training. methods: results by name. by_scene: too few scenes for means; every scene is a row.
        tracks: how many vehicles are scored, in words; "" where nobody counted.
    """

    name: str
    title: str
    trained_on: str
    seeds: tuple[int, ...]
    methods: Mapping[str, Results]
    by_scene: bool
    tracks: str = ""

    @property
    def scenes(self) -> int:
        """How many any method was measured on."""
        return max((len(results.scenarios) for results in self.methods.values()), default=0)


Pooled = Mapping[str, Mapping[str, Interval]]
"""method -> metric -> interval."""


def set_numbers(details: Mapping[str, Any]) -> dict[str, Interval]:
    """What only a whole set has, from the details of one evaluation (names with `.low` and `.high`)."""
    names = {key: _OF_SETS.get(key, key) for key in details if key in _OF_SETS or is_distance(key)}
    return {
        name: Interval(float(details[key]), *(float(details.get(f"{key}{end}", np.nan)) for end in (".low", ".high")))
        for key, name in names.items()
        if details[key] is not None
    }


def pool(data: DataSet, draws: int, rng: np.random.Generator) -> dict[str, dict[str, Interval]]:
    """Every metric of every method over seeds and scenes; scenes of one recording stay together."""
    out = {}
    resampling = resampling_of(data, draws, rng)
    for name, results in data.methods.items():
        out[name] = {metric: pooled_mean(values, resampling) for metric, values in sorted(results.values.items())}
        out[name] |= {metric: envelope(list(seeds)) for metric, seeds in sorted(results.sets.items())}
    return out


def tracks(scenes: Iterable[Scenario]) -> str:
    """How many vehicles are scored, in words; scenes of one recording may show the same one."""
    logged = [(scene, scene.log) for scene in scenes if scene.log is not None]
    seen = [(recording(scene.scenario_id), track) for scene, _ in logged for track in scene.vehicles.track_id]
    ended = sum(int(log.valid[:, -1].sum()) for _, log in logged)
    return f"{len(seen)} vehicles, {len(set(seen))} of them distinct tracks of a recording, {ended} seen to the last step."


def rows(data: DataSet, pooled: Pooled) -> list[dict[str, Any]]:
    """{data, method, metric, value, low, high, n, seeds, selector}: one number each; neither NaN nor counts."""
    return [
        {
            "data": data.name, "method": method, "metric": metric, "value": found.value, "low": _finite(found.low),
            "high": _finite(found.high), "n": len(data.methods[method].scenarios), "seeds": len(data.seeds),
            "selector": data.methods[method].chosen_by,
        }
        for method, metrics in pooled.items() for metric, found in metrics.items()
        if is_metric(metric) and np.isfinite(found.value)
    ]  # fmt: skip


def is_metric(name: str) -> bool:
    """Whether a row of an evaluation measures a method; false for what is only counted on the way."""
    return not name.startswith(_COUNTS)


def resampling_of(data: DataSet, draws: int, rng: np.random.Generator) -> Resampling:
    """`draws` resamples of a data set's seeds and recordings, the same for all its methods."""
    scenarios = next(iter(data.methods.values())).scenarios
    return Resampling.of(len(data.seeds), [recording(name) for name in scenarios], draws, rng)


def under_trained(method: str, pooled: Pooled) -> bool:
    """Whether a rival that was measured does not beat constant velocity in min-sADE."""
    if method not in pooled or _FLOOR not in pooled:
        return False
    return bool(pooled[method]["min_sade"].value >= pooled[_FLOOR]["min_sade"].value)


def is_distance(key: str) -> bool:
    """Whether a name in the details is a distance of distributions, and not an end of its interval."""
    return key.startswith("distance.") and not key.endswith((".low", ".high"))


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
