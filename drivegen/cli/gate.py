"""`drivegen gate`: whether a new version of a driver collides more often than the old one, for continuous integration."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import Annotated

from rich.table import Table
from typer import Argument, Exit, Option

from drivegen.cli._console import TABLE, plain
from drivegen.cli._drivers import driver_of
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import Interval
from drivegen.core.settings import build, read_section
from drivegen.corner_cases.gate import Gate, Settings, gate
from drivegen.gym.folders import SCENES, read_futures
from drivegen.metrics.paired import Finding
from drivegen.store.files import write_json
from drivegen.store.folders import whole_folder
from drivegen.store.lookup import CASES, is_round

RECORD = "gate.json"
WORSE, UNDECIDED = 3, 4
"""Exit codes."""

_DRIVER = "a driver of params.yaml, a YAML file with one and its settings, or a Python file, run with your rights."


def command(
    old: Annotated[str, Argument(help=f"The driver that is in use: {_DRIVER}")],
    new: Annotated[str, Argument(help=f"The one that is to take its place: {_DRIVER}")],
    scenarios: Annotated[
        Path, Option(help="A folder of scenarios, or of their futures: data/scenarios/test, data/generated/drivegen.")
    ],
    of: Annotated[Path, Option(help="Where the scenarios are that SCENARIOS holds futures of.")] = SCENES,
    out: Annotated[Path | None, Option(help=f"New folder for {RECORD}, with the runs in which only one collided.")] = None,
    most: Annotated[int | None, Option(min=1, help="Only the first so many scenarios, with all their futures.")] = None,
    avoidable: Annotated[bool, Option("--avoidable", help="Count only collisions that could have been avoided.")] = False,
    strict: Annotated[bool, Option("--strict", help=f"Exit with {UNDECIDED} where the two are not told apart.")] = False,
) -> None:
    """Drive OLD and NEW through the same scenes and say whether NEW is worse. Exits with 3 if it is, else with 0."""
    settings = build(Settings, read_section("gate.settings"), "stages/params.yaml: gate.settings")
    drivers, console = (driver_of(old), driver_of(new)), plain(least=TABLE)
    with _folder(out) as folder, console.status(f"driving {old} and {new}"):  # refused before anything is driven
        if any(_is_searched(place) for place in (scenarios, scenarios.resolve().parent)):
            raise UnusableInput(
                f"{scenarios} is a round of corner cases or an attack, made for what a driver did: a gate wants scenes that"
                " nobody chose, as data/generated/drivegen"
            )
        futures = read_futures(scenarios, of)
        first = set(list(dict.fromkeys(scenario.scenario_id for scenario, *_ in futures))[:most])
        chosen = [one for one in futures if one[0].scenario_id in first]
        settings = replace(settings, avoidable=avoidable or settings.avoidable)
        result = gate(*drivers, chosen, settings, read_section("run")["seed"])
        if folder:
            write_json(folder / RECORD, {"old": old, "new": new, "folder": str(scenarios), **result.record(old, new)})
    console.print(_table(result, old, new))
    if isnan(result.shares[0].low):
        console.print("too few recordings for an interval")
    console.print(result.sentence(old, new))
    if result.finding == Finding.WORSE:
        raise Exit(WORSE)
    if strict and result.finding == Finding.UNDECIDED:
        raise Exit(UNDECIDED)


def _is_searched(folder: Path) -> bool:
    return (folder / CASES).is_file() or is_round(folder)


@contextmanager
def _folder(out: Path | None) -> Iterator[Path | None]:
    """The folder that is written, whole or not at all, where one is asked for."""
    if out is None:
        yield None
        return
    with whole_folder(out) as folder:
        yield folder


def _table(result: Gate, old: str, new: str) -> Table:
    paired, shares = result.paired, [_share(one) for one in result.shares]
    table = Table("driver", result.counted, "share of runs (95 %)", "it alone", box=None, pad_edge=False)
    table.add_row(f"old: {old}", str(paired.old), shares[0], str(paired.only_old))
    table.add_row(f"new: {new}", str(paired.new), shares[1], str(paired.only_new))
    table.add_row("new less old", f"{paired.new - paired.old:+d}", shares[2], f"{paired.only_new - paired.only_old:+d}")
    return table


def _share(share: Interval) -> str:
    return f"{share.value:.2%}" + (f" ({share.low:.2%} to {share.high:.2%})" if share.low < share.high else "")
