"""Stage naturalness: how likely a generator that made none of it holds what attackers do, beside what they did before.

argv: scenarios of one split, models, traffic as it is (folder of shards), cases (folder <driver>/<attack>), results (JSON, a
list of rows {method, allowed, found_for, metric, value, low, high, n}). Values are in the unit of the judge's log likelihood.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drivegen.adversaries.shared.naturalness import LikelihoodModel, naturalness
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import bootstrap_means, recording
from drivegen.core.samples import Samples
from drivegen.core.seeds import rng
from drivegen.core.settings import Count
from drivegen.store.files import write_json
from stages._cases import Traffic, attacked_scenes, read_cases, read_traffic

METRICS = ("attack", "before", "less")
"""As the attackers move, as they did before, and the one less the other."""


@dataclass(frozen=True)
class Params:
    """`judge`: a generator with `log_likelihood`; `attacks`: whose cases, folders of each of the `drivers`; bootstrap `draws`."""

    seed: int
    judge: str
    attacks: list[str]
    drivers: list[str]
    draws: Count

    def __post_init__(self) -> None:
        for attack in self.attacks:
            if attack.count(".") != 2:
                raise UnusableInput(f"stages/params.yaml: naturalness.attacks: {attack!r} is no <method>.<allowed>.<queries>")


def main(params: Params, scenarios: Path, models: Path, traffic: Path, cases: Path, results: Path) -> None:
    """Every attack on every driver."""
    kind = plugins.load("generators", params.judge)
    if not hasattr(kind, "log_likelihood"):
        raise UnusableInput(f"stages/params.yaml: naturalness.judge is {params.judge!r}, which has no log_likelihood: smart has")
    judge: LikelihoodModel = kind(models, None)
    as_it_is, rows = read_traffic(scenarios, traffic), []
    for driver in params.drivers:
        for attack in params.attacks:
            method, allowed, _ = attack.split(".")
            likelihoods = _judged(judge, read_cases(cases / driver / attack, as_it_is), as_it_is, params)
            rows += [{"method": method, "allowed": allowed, "found_for": driver, **row} for row in likelihoods]
    write_json(results, rows)


def _judged(judge: LikelihoodModel, cases: list[Samples], as_it_is: Traffic, params: Params) -> Iterator[dict[str, Any]]:
    """Means over the cases in which somebody was attacked, with 95 % over recordings."""
    if not cases:
        return
    scenarios, before = attacked_scenes(cases, as_it_is)
    both = naturalness(judge, scenarios, before, [case.motion[0] for case in cases])
    there = np.flatnonzero(np.isfinite(both).all(1))
    recordings, random = [recording(cases[c].scenario_id) for c in there.tolist()], rng(params.seed, "naturalness", "bootstrap")
    columns = np.column_stack([both[there], both[there, 0] - both[there, 1]])
    if len(there):
        for metric, interval in zip(METRICS, bootstrap_means(columns, recordings, params.draws, random), strict=True):
            yield {"metric": metric, **asdict(interval), "n": len(there)}
