"""Stage survival: which cases hold when neighbours react, by whom they react to and by how soon and how hard they brake.

argv: scenarios of one split, traffic as it was (folder of shards), cases (a folder of each driver, in it one of each attack),
results (JSON, a list of rows {method, driver, attention, reacting, value, low, high, n}).
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drivegen.adversaries.shared.held import replays
from drivegen.core import plugins
from drivegen.core.intervals import bootstrap_means, recording
from drivegen.core.samples import Samples
from drivegen.core.seeds import rng
from drivegen.core.settings import Count
from drivegen.corner_cases.survival import attentions, survival
from drivegen.drivers.base import Driver
from drivegen.store.files import write_json
from drivegen.world.reactive import Reaction
from stages._cases import Traffic, attacked_scenes, read_cases, read_traffic


@dataclass(frozen=True)
class Params:
    """Section `survival`.

    Attributes:
        attacks: whose cases, folders of each of the `drivers`. reaction: of neighbours, delay and braking apart.
        draws: bootstrap draws behind intervals.
    """

    seed: int
    attacks: list[str]
    drivers: dict[str, dict[str, Any]]
    reaction: Reaction
    draws: Count


def main(params: Params, scenarios: Path, traffic: Path, cases: Path, results: Path) -> None:
    """The cases of every driver, driven by it again."""
    as_it_is, rows = read_traffic(scenarios, traffic), []
    for name in params.drivers:
        driver = plugins.make("drivers", name, params.drivers, "survival.drivers")
        for attack in params.attacks:
            attack_cases = read_cases(cases / name / attack, as_it_is)
            rows += [
                {"method": attack.partition(".")[0], "driver": name, **row}
                for row in _held(attack_cases, as_it_is, driver, params)
            ]
    write_json(results, rows)


def _held(cases: list[Samples], as_it_is: Traffic, driver: Driver, params: Params) -> Iterator[dict[str, Any]]:
    """Of every way of reacting the share of the cases that hold, with 95 % over recordings."""
    if not cases:
        return
    scenarios, before = attacked_scenes(cases, as_it_is)
    again = replays(scenarios, before, [case.motion[0] for case in cases], driver, params.reaction)
    held = survival(again, driver, attentions(params.reaction))
    columns = np.column_stack(list(held.values())).astype(np.float64)
    recordings, random = [recording(case.scenario_id) for case in cases], rng(params.seed, "survival", "bootstrap")
    for (name, who), interval in zip(held, bootstrap_means(columns, recordings, params.draws, random), strict=True):
        yield {"attention": name, "reacting": str(who), **asdict(interval), "n": len(cases)}
