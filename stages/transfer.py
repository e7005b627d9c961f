"""Stage transfer: cases that were found for one driver are driven by all others, who were not searched against.

argv: scenarios of one split, traffic as it is (folder of shards), cases (folder <driver>/<attack>), what became of them (JSON,
a list of rows {method, found_for, driver, metric, value, low, high, n}). Neighbours are replayed, as in the search.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drivegen.adversaries.shared.naturalness import exchanged
from drivegen.core import plugins
from drivegen.core.intervals import bootstrap_means, recording
from drivegen.core.samples import Samples
from drivegen.core.seeds import rng
from drivegen.core.settings import Count
from drivegen.store.files import write_json
from stages._cases import Traffic, attacked_scenes, read_cases, read_traffic

SIMULATOR = "batch"


@dataclass(frozen=True)
class Params:
    """`attacks`: whose cases, each a folder of the stage `attack`, by method; `drivers`: who drives; `draws` of the bootstrap."""

    seed: int
    attacks: dict[str, str]
    drivers: dict[str, dict[str, Any]]
    draws: Count


def main(params: Params, scenarios: Path, traffic: Path, cases: Path, results: Path) -> None:
    """Every driver in the cases of every driver."""
    as_it_is, rows = read_traffic(scenarios, traffic), []
    for found_for in params.drivers:
        for method, attack in params.attacks.items():
            attack_cases = read_cases(cases / found_for / attack, as_it_is)
            rows += [{"method": method, "found_for": found_for, **row} for row in _driven(attack_cases, as_it_is, params)]
    write_json(results, rows)


def _driven(cases: list[Samples], as_it_is: Traffic, params: Params) -> Iterator[dict[str, Any]]:
    """Of each driver the share of the cases in which it has a counted collision, and of their scenes without the attack.

    Cases in which nobody was exchanged are left out: they are these scenes.
    """
    scenarios, untouched = attacked_scenes(cases, as_it_is)
    rows = [n for n, case in enumerate(cases) if len(exchanged(untouched[n], case.motion[0]))]
    if not rows:
        return
    scenarios, untouched = [scenarios[n] for n in rows], [untouched[n] for n in rows]
    drivers = [plugins.make("drivers", name, params.drivers, "transfer.drivers") for name in params.drivers]
    recordings = [recording(scenario.scenario_id) for scenario in scenarios]
    for metric, traffic in (("counted", [cases[n].motion[0] for n in rows]), ("untouched", untouched)):
        outcomes = plugins.load("simulators", SIMULATOR)().run_each(drivers, scenarios, traffic)
        columns = np.array([outcome.counted for outcome in outcomes], np.float64).T
        random = rng(params.seed, "transfer", "bootstrap")
        for driver, interval in zip(params.drivers, bootstrap_means(columns, recordings, params.draws, random), strict=True):
            yield {"driver": driver, "metric": metric, **asdict(interval), "n": len(rows)}
