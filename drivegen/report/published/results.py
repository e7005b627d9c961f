"""What is published: every method on every data set, over scenes and seeds, as intervals and as rows."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegen.core.intervals import Interval, recording, usual_length
from drivegen.core.methods import BOUND, Method
from drivegen.core.scenario import Scenario
from drivegen.metrics.pooled import Resampling, envelope, pooled_mean
from drivegen.report.averaged import scenes_and_recordings
from drivegen.report.published.figures import as_columns

Floats = NDArray[np.float64]

OURS = "drivegen"
"""Whose differences to the others are published."""

_JOINT = ("joint.order", "shuffled.order", "shuffled.headway", "shuffled.post_encroachment")
_OF_SETS = {"diversity_ratio": "diversity", "auc": "auc", **{name: name for name in _JOINT}}
"""Names in the details of an evaluation, and here: what only a whole set of scenes has. `distance.*` keep their names."""

BOTH = "checker+tempo"
ADDED = {"none": "as it is", "tempo": "+ tempo", "checker": "+ checker", BOTH: "+ both"}
"""What may stand behind a name in `DataSet.added`, in words."""

_COUNTS = ("steps", "agent_steps", "vehicles", "bandwidth.", "manoeuvre.", "label.")
"""What evaluation counts on the way to its metrics: says how much was measured, not how well anybody did."""


class Run(NamedTuple):
    """The seeds of one run of a data set: of training, and of the futures."""

    training: int
    sampling: int

    @property
    def folder(self) -> str:
        """Below that of the data set."""
        return f"{self.training}-{self.sampling}"


def pairs(training: Iterable[int], sampling: Iterable[int]) -> list[Run]:
    """The runs of a data set: every training seed with every sampling seed."""
    return [Run(*pair) for pair in product(training, sampling)]


@dataclass(frozen=True)
class Results:
    """One method on one data set.

    Attributes:
        scenarios: ids of N scenes. values: (S, N) by metric, one row a run, NaN where there is none.
        sets: an interval a run, by the name of what only a whole set has: of scenes of the usual length, see `metrics.whole`.
        chosen_by: who chose goals, in words.
        plateau: whether the roll-outs of all its trained models had stopped gaining in every run; None where none tells, or
            nothing is trained.
    """

    scenarios: tuple[str, ...]
    values: Mapping[str, Floats]
    sets: Mapping[str, list[Interval]]
    chosen_by: str
    plateau: bool | None = None

    @property
    def averaged(self) -> "Results":
        """The same of the scenes that are as long as most."""
        return self.only(self.usual)

    @property
    def usual(self) -> NDArray[np.bool_]:
        """(N,) which scenes are as long as most; all, where nobody wrote down how long they are."""
        steps = self.values["steps"][0] if "steps" in self.values else np.zeros(len(self.scenarios))
        return np.asarray(steps == usual_length(steps)) if len(steps) else np.ones(0, np.bool_)

    def only(self, mask: NDArray[np.bool_]) -> "Results":
        """The same of the scenes that are `mask` (N,)."""
        names = tuple(name for name, keep in zip(self.scenarios, mask, strict=True) if keep)
        return replace(self, scenarios=names, values={metric: values[:, mask] for metric, values in self.values.items()})


@dataclass(frozen=True)
class DataSet:
    """All methods on one data set.

    Attributes:
        name, title: in the JSON, and in words. trained_on: what models were trained on, in words.
        runs: those that were evaluated. about: every generator, in the tables' order. methods: results by name, of some of these.
        by_scene: too few scenes for means; every scene is a row.
        tracks: how many vehicles are scored, in words; "" where nobody counted.
        added: results by `<name>/<additions>`, see stage additions, those of a method as it is under `<name>/none`.
        left_out: results by name on scenes of another length, which are shown scene by scene and not averaged.
    """

    name: str
    title: str
    trained_on: str
    runs: tuple[Run, ...]
    about: Mapping[str, Method]
    methods: Mapping[str, Results]
    by_scene: bool
    tracks: str = ""
    added: Mapping[str, Results] = field(default_factory=dict)
    left_out: Mapping[str, Results] = field(default_factory=dict)

    @property
    def seeds(self) -> tuple[int, ...]:
        """Of training."""
        return tuple(dict.fromkeys(run.training for run in self.runs))

    @property
    def sampling_seeds(self) -> tuple[int, ...]:
        """Of the futures."""
        return tuple(dict.fromkeys(run.sampling for run in self.runs))

    @property
    def rows(self) -> dict[str, Method]:
        """The rows of a table: whoever was measured or could be; one that nobody ran reads "not measured"."""
        return {name: method for name, method in self.about.items() if name in self.methods or method.kind != BOUND}

    @property
    def generators(self) -> dict[str, Method]:
        """Whoever was measured and is told nothing of what happened."""
        return {name: method for name, method in self.about.items() if name in self.methods and method.kind != BOUND}

    @property
    def every(self) -> dict[str, Results]:
        """Results by method, then those with additions."""
        return {**self.methods, **self.added}

    @property
    def scenes(self) -> int:
        """How many any method was measured on."""
        return max((len(results.scenarios) for results in self.methods.values()), default=0)

    @property
    def rolled_out(self) -> int:
        """How many scenes every method generated, those that are not averaged among them."""
        return self.scenes + max((len(results.scenarios) for results in self.left_out.values()), default=0)

    @property
    def over(self) -> str:
        """What means and intervals are over, in words."""
        first = next(iter(self.methods.values()))
        counted = "steps" in first.values
        left_out = next((other.values["steps"][0] for other in self.left_out.values()), ())
        others = Counter(int(steps) for steps in left_out)
        recordings = len({recording(name) for name in first.scenarios})
        steps = int(first.values["steps"][0, 0]) if counted else None
        return scenes_and_recordings(len(first.scenarios), recordings, steps, others)


def split(every: Mapping[str, Results]) -> tuple[dict[str, Results], dict[str, Results]]:
    """Results by method on scenes that are averaged, and on those of another length: nothing where there are none."""
    averaged = {method: results.averaged for method, results in every.items()}
    others = {method: results.only(~results.usual) for method, results in every.items()}
    return averaged, others if any(results.scenarios for results in others.values()) else {}


Pooled = Mapping[str, Mapping[str, Interval]]
"""method -> metric -> mean."""


def set_numbers(details: Mapping[str, Any]) -> dict[str, Interval]:
    """What only a whole set has, from the details of one evaluation (names with `.low` and `.high`)."""
    names = {key: _OF_SETS.get(key, key) for key in details if key in _OF_SETS or is_distance(key)}
    return {name: interval_of(details, key) for key, name in names.items() if details[key] is not None}


def interval_of(details: Mapping[str, Any], key: str) -> Interval:
    """`details[key]` with its ends `key.low` and `key.high`; NaN is what is not there or null, as JSON has no NaN."""
    return Interval(*(np.nan if (value := details.get(f"{key}{end}")) is None else float(value) for end in ("", ".low", ".high")))


def pool(data: DataSet, draws: int, rng: np.random.Generator) -> dict[str, dict[str, Interval]]:
    """Every metric of every method over seeds and scenes; scenes of one recording stay together."""
    out = {}
    resampling = resampling_of(data, draws, rng)
    for name, results in data.every.items():
        out[name] = {metric: pooled_mean(values, resampling) for metric, values in sorted(results.values.items())}
        out[name] |= {metric: envelope(list(seeds)) for metric, seeds in sorted(results.sets.items())}
    return out


def tracks(scenes: Iterable[Scenario], methods: Mapping[str, Results]) -> str:
    """How many vehicles are scored, in words, "" without scenes; those of one recording may show the same one."""
    scored = {name for results in methods.values() for name in results.scenarios}
    logged = [(scene, scene.log) for scene in scenes if scene.log is not None and scene.scenario_id in scored]
    vehicles = [(recording(scene.scenario_id), track) for scene, _ in logged for track in scene.vehicles.track_id]
    ended = sum(int(log.valid[:, -1].sum()) for _, log in logged)
    text = (
        f"{len(vehicles)} vehicles, {len(set(vehicles))} of them distinct tracks of a recording, {ended} seen to the last step."
    )
    return text if vehicles else ""


def rows(data: DataSet, pooled: Pooled) -> list[dict[str, Any]]:
    """One number each, neither NaN nor counts: {data, method, metric, value, low, high, n, seeds, sampling_seeds, plateau,
    additions, selector}."""
    every = data.every
    return [
        {
            "data": data.name, "method": name.partition("/")[0], "metric": metric, **as_columns(mean),
            "n": len(every[name].scenarios), "seeds": len(data.seeds),
            "sampling_seeds": len(data.sampling_seeds), "plateau": data.methods[name.partition("/")[0]].plateau,
            "additions": list(_additions(data, name)), "selector": every[name].chosen_by,
        }
        for name, metrics in pooled.items() for metric, mean in metrics.items()
        if is_metric(metric) and np.isfinite(mean.value) and not name.endswith("/none")
    ]  # fmt: skip


def _additions(data: DataSet, name: str) -> Sequence[str]:
    """Those of a method, or of its futures with some."""
    method, _, added = name.partition("/")
    return added.split("+") if added else data.about[method].additions


def is_metric(name: str) -> bool:
    """Whether a row of an evaluation measures a method; false for what is only counted on the way."""
    return not name.startswith(_COUNTS)


def resampling_of(data: DataSet, draws: int, rng: np.random.Generator) -> Resampling:
    """`draws` resamples of a data set's runs and recordings, the same for all its methods."""
    scenarios = next(iter(data.methods.values())).scenarios
    return Resampling.of(data.runs, [recording(name) for name in scenarios], draws, rng)


def is_distance(key: str) -> bool:
    """Whether a name in the details is a distance of distributions, and not an end of its interval."""
    return key.startswith("distance.") and not key.endswith((".low", ".high"))
