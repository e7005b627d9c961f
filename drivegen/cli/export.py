"""`drivegen export`: scenarios out of the pipeline's shards, each as a folder in the official layout."""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Annotated

from rich.console import Console
from typer import Argument, Option

from drivegen.av2.export import export_scenario
from drivegen.errors import UnusableInput
from drivegen.scenario import Scenario
from drivegen.store.folders import whole_folder
from drivegen.store.scenarios import read_shard, shards


def command(
    scenarios: Annotated[Path, Argument(help="A folder of shards, e.g. data/shipped or data/scenarios/test, or one shard.")],
    out: Annotated[Path, Option(help="New folder for <id>/ (official Motion Forecasting layout).")],
    most: Annotated[int | None, Option(min=1, help="Only the first so many.")] = None,
) -> None:
    """Write the scenarios of SCENARIOS for other programs: Motion Forecasting folders that `drivegen view` and av2 open."""
    found = _shards(scenarios)
    count = 0
    with whole_folder(out) as folder:
        for scenario in islice(_all(found), most):
            if scenario.log is None:
                raise UnusableInput(
                    f"{scenarios}: scenario {scenario.scenario_id} has no motion yet: give scenarios that drove, as data/shipped"
                )
            export_scenario(scenario, scenario.log, folder, scenario.scenario_id.replace(":", "-"))
            count += 1
        if not count:
            raise UnusableInput(f"{scenarios} holds no scenario")
    Console(soft_wrap=True, highlight=False, markup=False).print(f"{out}: {count} scenarios of {scenarios}")


def _shards(place: Path) -> list[Path]:
    if place.is_file():
        return [place]
    if found := shards(place):
        return found
    raise UnusableInput(f"{place} holds no shard-*.parquet: `make run` writes them, e.g. to data/shipped")


def _all(found: list[Path]) -> Iterator[Scenario]:
    for shard in found:
        yield from read_shard(shard)
