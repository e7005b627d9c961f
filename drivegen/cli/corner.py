"""`drivegen corner`: what makes a driver fail, by kind, with odds, whether it could have been avoided, and files to look at."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from rich.table import Table
from typer import Option

from drivegen.adversaries.shared.arena import Arena, Bounds
from drivegen.cli import _project
from drivegen.cli._console import TABLE, plain
from drivegen.cli._drivers import driver_of
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.core.settings import Count, Index, read_section
from drivegen.core.wording import many
from drivegen.corner_cases.avoidance import Avoidable
from drivegen.corner_cases.case import Case
from drivegen.corner_cases.judgement import Judgement, judgements
from drivegen.corner_cases.kind_folder import write_kind
from drivegen.corner_cases.kinds import Group, groups
from drivegen.corner_cases.survival import Reacting
from drivegen.drivers.base import Driver
from drivegen.gym.folders import read_traffic
from drivegen.store.files import write_json
from drivegen.store.folders import whole_folder
from drivegen.world.reactive import Reaction

CASES = "cases.json"


@dataclass(frozen=True)
class _Settings:
    """What of params.yaml, `attack`, a search needs (see `stages/attack.py`); of `queries` the first counts."""

    samples: Count
    queries: list[Count]
    reaction_steps: Index
    reaction: Reaction
    adversaries: dict[str, dict[str, Any]]


def command(
    driver: Annotated[
        str,
        Option(help="A driver of params.yaml, a YAML file with one and its settings, or a Python file, run with your rights."),
    ],
    scenarios: Annotated[Path, Option(help="A folder of scenarios: data/scenarios/test, data/shipped, Argoverse 2's layout.")],
    out: Annotated[Path, Option(help="New folder, with one of each kind of cases.")],
    adversary: Annotated[str, Option(help="Who looks for them: a file of drivegen/adversaries.")] = "drivegen_cs",
    most: Annotated[int | None, Option(min=1, help="Only the first so many scenarios.")] = None,
) -> None:
    """Find what makes DRIVER fail: legal traffic that it collides in, judged, by kind, written for other programs."""
    settings, tested, console = _settings(), driver_of(driver), plain(least=TABLE)
    doing = f"looking for what makes {tested.name} fail, and judging it"
    with whole_folder(out) as folder, console.status(doing):  # refused before the search, which takes minutes
        where = {scenario.scenario_id: scenario for scenario, _ in read_traffic(scenarios)}
        cases, runs = _cases(tested, adversary, list(where.values())[:most], settings)
        kinds = groups(cases)
        judged = judgements(cases, tested, settings.reaction)
        for group in kinds:
            write_kind(folder / _folder(group), judged[group.cases[0]])
        write_json(folder / CASES, [_row(one) for one in judged])
    searched = f"{tested.name}: {many(runs, 'run')} in {many(min(most or len(where), len(where)), 'scenario')}"
    if not cases:
        console.print(f"{searched}, no case found")
        return
    console.print(_table(kinds, judged))
    odds = "Odds, of the attacker's goal by itself (of two attackers the product of both)"
    console.print(f"{odds}, and time to react are medians. The likeliest case of each kind:")
    for group in kinds:
        place, likeliest = out / _folder(group), judged[group.cases[0]]
        written = ", ".join(sorted(file.name for file in place.iterdir()))
        console.print(f"{group.kind}, in {likeliest.case.scenario_id}: {likeliest.sentence}\n  {place}: {written}")
    found = sum(len(group.cases) for group in kinds)
    console.print(f"{searched}, {many(found, 'case')} of {many(len(kinds), 'kind')} in {out}")


def _settings() -> _Settings:
    settings = _project.some_of(_Settings, "attack")
    if not settings.queries:
        raise UnusableInput("params.yaml: attack.queries is empty: say how often the driver may be run in each scenario")
    return settings


def _cases(driver: Driver, adversary: str, scenarios: Sequence[Scenario], attack: _Settings) -> tuple[list[Case], int]:
    """The counted collisions that the adversary finds, each a case, and how often the driver was run."""
    attacker = plugins.make("adversaries", adversary, attack.adversaries, "attack.adversaries")
    ground = _project.ground(plugins.about("adversaries", adversary)["traffic"], scenarios, attack.samples)
    arena = Arena(driver, ground, Bounds("legal", attack.queries[0], attack.reaction_steps), read_section("run")["seed"])
    attacker.attack(arena)
    runs = arena.runs()
    good = np.flatnonzero(runs.outcome.counted).tolist()
    return [runs.case(run, driver.name, adversary) for run in good], int(arena.spent.sum())


def _folder(group: Group) -> str:
    return group.kind.replace(" ", "-")


def _table(kinds: Sequence[Group], judged: Sequence[Judgement]) -> Table:
    table = Table("kind", "cases", "odds", "avoidable", "time to react", "holds when all react", box=None, pad_edge=False)
    for group in kinds:
        mine = [judged[c] for c in group.cases]
        avoidable = sum(one.replayed.verdict != Avoidable.NO for one in mine)
        holds = sum(one.holds["ordinary", Reacting.ALL] for one in mine)
        odds, budget = _median([m.case.odds for m in mine], ".2g"), _median([m.replayed.budget for m in mine], ".1f", " s")
        shares = (f"{count} of {len(mine)}" for count in (avoidable, holds))
        table.add_row(group.kind, str(len(mine)), odds, next(shares), budget, next(shares))
    return table


def _median(values: Sequence[float], how: str, unit: str = "") -> str:
    there = [value for value in values if not np.isnan(value)]
    return f"{np.median(there):{how}}{unit}" if there else "-"


def _track(case: Case, number: int) -> str:
    """The track id of a vehicle of the scenario or, from the number of vehicles on, of a person: the same in every file."""
    vehicles, context = case.scenario.vehicles, case.scenario.context
    return str(vehicles.track_id[number] if number < len(vehicles) else context.track_id[number - len(vehicles)])


def _row(one: Judgement) -> dict[str, Any]:
    """A case for programs."""
    case = one.case
    return {
        "scenario": case.scenario_id,
        "kind": one.kind,
        "sentence": one.sentence,
        "attacker": case.attacker or None,  # in logged traffic nobody was given another motion
        "partner": case.partner,
        "tracks": {"attacker": _track(case, case.attacker) if case.attacker else None, "partner": _track(case, case.partner)},
        "seconds": round(case.step * 0.1, 1),
        "odds": None if np.isnan(case.odds) else case.odds,
        "avoidable": one.replayed.verdict,
        "time_to_react": None if np.isnan(one.replayed.budget) else round(one.replayed.budget, 1),
        "avoidable_reacting": one.reacting.verdict,
        "holds": {f"{who}, {attention}": held for (attention, who), held in one.holds.items()},
        "query": case.queries,
    }
