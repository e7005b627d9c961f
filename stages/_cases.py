"""What stages read that look again at the cases of an attack: generated traffic as it was, and the cases found in it."""

from collections.abc import Sequence
from pathlib import Path

from drivegen.adversaries.shared.legal import legal
from drivegen.adversaries.shared.naturalness import exchanged
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.store.lookup import CASES, futures_in
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import shards
from stages._door import require

Traffic = dict[str, tuple[Scenario, list[Trajectories]]]
"""By the id of a scenario: it, and its generated scenes as attackers see them."""


def read_traffic(scenarios: Path, traffic: Path) -> Traffic:
    """The generated scenes (`traffic`, a folder of shards) of each of the `scenarios` (one, too)."""
    as_it_is: Traffic = {}
    for shard in shards(require(scenarios, "run the ingest stage")):
        futures = futures_in(require(traffic / shard.name, "run the corner stage"), scenarios)
        for scenario, samples in futures:
            as_it_is[scenario.scenario_id] = scenario, [legal(samples, k) for k in range(len(samples.dropped))]
    return as_it_is


def read_cases(folder: Path, as_it_is: Traffic) -> list[Samples]:
    """The cases in the folder of an attack. Raises UnusableInput where one is of no scenario that is there, or of its log."""
    method = folder.name.partition(".")[0]
    if plugins.about("adversaries", method)["traffic"] == "log":
        raise UnusableInput(f"{folder.name} attacks logs, which are compared with no generated traffic: name another attack")
    cases = read_samples(require(folder / CASES, "run the attack stages"))
    if unknown := {case.scenario_id for case in cases} - as_it_is.keys():
        raise UnusableInput(
            f"cases are of scenario {min(unknown)}, which is not among the scenarios: run the attack stages again"
        )
    return cases


def attacked_scenes(cases: Sequence[Samples], as_it_is: Traffic) -> tuple[list[Scenario], list[Trajectories]]:
    """Of each case its scenario, and which of its scenes was attacked: the one in which fewest vehicles move otherwise."""
    scenarios, before = list[Scenario](), list[Trajectories]()
    for case in cases:
        scenario, scenes = as_it_is[case.scenario_id]
        scenarios.append(scenario)
        before.append(min(scenes, key=lambda scene: len(exchanged(scene, case.motion[0]))))
    return scenarios, before
