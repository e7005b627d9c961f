"""`drivegen rate`: how often a driver fails in law-abiding generated traffic, from few runs of it."""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated

from rich.console import Console
from rich.progress import track
from rich.table import Table
from typer import Option

from drivegen.cli import _project
from drivegen.cli._console import plain
from drivegen.cli._drivers import driver_of
from drivegen.cli._files import RATE, expect_own
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.core.seeds import rng
from drivegen.core.settings import Count, read_section
from drivegen.core.wording import many
from drivegen.exposure.pool import Drawn, Pool, draw_scenes, driven_seconds, with_enough
from drivegen.exposure.rates import EDGES, Estimate, estimate
from drivegen.gym.folders import read_traffic
from drivegen.store.files import write_json
from drivegen.world.reactive import Reaction

HOUR = 3600.0


@dataclass(frozen=True)
class _Settings:
    """What of stages/params.yaml, `rates`, is asked for here (see `stages/rates.py`)."""

    draws: Count
    tries: Count
    reaction: Reaction


def command(
    driver: Annotated[
        str,
        Option(help="A driver of params.yaml, a YAML file with one and its settings, or a Python file, run with your rights."),
    ],
    scenarios: Annotated[Path, Option(help="A folder of scenarios: data/scenarios/test, data/shipped, Argoverse 2's layout.")],
    runs: Annotated[int, Option(min=10, max=10**9, help="Of the driver at most, beside one in each scene.")] = 2000,
    draws: Annotated[int | None, Option(min=1, help="Of the traffic of each scene, from which runs are chosen.")] = None,
    most: Annotated[int | None, Option(min=1, help="Only the first so many scenarios.")] = None,
    out: Annotated[Path | None, Option(help="A JSON file for what was found.")] = None,
) -> None:
    """Say how often DRIVER fails in law-abiding generated traffic, with an interval, running it where others come near."""
    if out:
        expect_own(out, RATE)
    settings, tested, seed = _settings(draws), driver_of(driver), read_section("run")["seed"]
    where = {scenario.scenario_id: scenario for scenario, _ in read_traffic(scenarios)}
    scenes, left_out = _draw(list(where.values())[:most], settings, seed)
    if not scenes:
        raise UnusableInput(
            f"{scenarios}: in none of {len(left_out)} scenes are {settings.draws} of {settings.tries} draws legal"
        )
    pool = Pool(scenes, tested, settings.reaction)
    first = pool.first(tested)
    result = estimate(pool.near(first), lambda picks: pool.failed(tested, picks), runs, rng(seed, "rate"))
    console = plain()
    console.print(_table(result))
    seconds = float(driven_seconds(first).mean())
    console.print(_sentence(tested.name, result, seconds, len(scenes), len(left_out)))
    if out:
        about = {"driver": driver, "folder": str(scenarios), "scenes": len(scenes), "left_out": left_out, "draws": settings.draws}
        strata = {"edges": EDGES.tolist(), "share": result.share.tolist(), "runs": result.runs.tolist()}
        strata |= {"failed": result.failed.tolist()}
        write_json(out, about | asdict(result.rate) | {"seconds": seconds, "strata": strata})


def _settings(draws: int | None) -> _Settings:
    settings = _project.some_of(_Settings, "rates")
    settings = replace(settings, draws=draws or settings.draws)
    if settings.draws > settings.tries:
        raise UnusableInput(f"--draws {settings.draws} are more than are tried: at most {settings.tries} (rates.tries)")
    return settings


def _draw(scenarios: list[Scenario], settings: _Settings, seed: int) -> tuple[list[Drawn], list[str]]:
    """Everybody's goals are drawn by the law; the target is told to drive where it does in a first future."""
    ground, console = _project.ground("generated", scenarios, 1), Console(stderr=True)
    drawn = draw_scenes(ground, settings.draws, settings.tries, seed)
    watched = track(drawn, "drawing traffic", len(ground.of), console=console, disable=not console.is_terminal)
    return with_enough(watched, settings.draws)


def _table(result: Estimate) -> Table:
    table = Table("others come as near as", "share of draws", "runs", "failed", box=None, pad_edge=False)
    names = [*(f"less than {edge:g} m" for edge in EDGES), "farther"]
    for name, share, runs, failed in zip(names, result.share, result.runs, result.failed, strict=True):
        table.add_row(name, f"{share:.2%}", str(runs), str(failed))
    return table


def _sentence(name: str, result: Estimate, seconds: float, count: int, left_out: int) -> str:
    rate, hourly = result.rate, HOUR / seconds
    scenes = many(count, "scene") + (f" ({left_out} more have too little that is legal)" if left_out else "")
    return (
        f"{name}: {rate.value:.2g} counted collisions a scene (95 %: {rate.low:.2g} to {rate.high:.2g}), "
        f"{hourly * rate.value:.2g} an hour ({hourly * rate.low:.2g} to {hourly * rate.high:.2g}), by "
        f"{result.runs.sum() + count} runs in {scenes}. Generated traffic that keeps the rules, neighbours that "
        "react; in other scenes it would be another rate."
    )
