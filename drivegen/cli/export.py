"""`drivegen export`: scenarios out of the pipeline's shards, in any format that `drivegen/exporters` writes."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Annotated

import numpy as np
from typer import Argument, Option

from drivegen.cli._console import plain
from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import boxes_overlap
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.core.wording import many
from drivegen.exporters.base import Exporter
from drivegen.gym.folders import within
from drivegen.rollout.shipping import sample_id
from drivegen.store.folders import whole_folder
from drivegen.store.lookup import CASES, DRIVEN, DRIVEN_CASES, SAMPLES, cases_in, futures_in, is_round
from drivegen.store.samples import holds_samples, read_samples
from drivegen.store.scenarios import read_shard, shards

_REMEDY = "give a folder of shards, as data/shipped, which `make run` writes"

Shards = Annotated[
    Path,
    Argument(
        help="A folder of shards, or one: data/shipped, data/scenarios/test, data/generated/METHOD, data/corner/ROUND; "
        "or of an attack's cases: data/attack/DRIVER/ATTACK."
    ),
]
Of = Annotated[Path, Option(help="The scenarios that data/generated, data/corner and data/attack hold futures of.")]
Collisions = Annotated[bool, Option("--collisions", help="Of a round: only futures that end with the driver's collision.")]


def _formats() -> str:
    """Every format by its name, with its title and what reads it."""
    about = {name: plugins.about("exporters", name) for name in plugins.names("exporters")}
    return "; ".join(f"{name}: {one['title']}, for {one['read_by']}" for name, one in about.items())


To = Annotated[str, Option(help=f"The format. {_formats()}.")]
Driven = Annotated[bool, Option("--driven", help="Of a round or attack: the target as the driver drove it, not as planned.")]


def command(
    scenarios: Shards,
    out: Annotated[Path, Option(help="New folder for one folder or file of each scenario, called by its id.")],
    most: Annotated[int | None, Option(min=1, max=sys.maxsize, help="Only the first so many.")] = None,
    of: Of = Path("data/scenarios/test"),
    collisions: Collisions = False,
    driven: Driven = False,
    to: To = "argoverse2",
) -> None:
    """Write the scenarios of SCENARIOS for other programs: as Motion Forecasting folders, or in the format that --to names."""
    exporter: Exporter = plugins.load("exporters", to)()
    chosen = _scenarios(scenarios, _Choice(of, collisions, driven))
    count = 0
    with whole_folder(out) as folder:
        for scenario in islice(chosen, most):
            if scenario.log is None:
                raise UnusableInput(
                    f"{scenarios}: scenario {scenario.scenario_id} has no motion yet: give scenarios that drove, as data/shipped"
                )
            exporter.write(scenario, scenario.log, folder, scenario.scenario_id.replace(":", "-"))
            count += 1
        if not count:
            raise UnusableInput(f"{scenarios} holds no scenario" + (" that a collision ends" if collisions else ""))
    plain().print(f"{out}: {many(count, 'scenario')} of {scenarios}")


@dataclass(frozen=True)
class _Choice:
    """Of samples: the folder of their scenarios; of a round, whether only collisions, and whose motion the target has."""

    of: Path
    collisions: bool
    driven: bool


def _scenarios(place: Path, choice: _Choice) -> Iterator[Scenario]:
    """What a folder or a shard holds, scenario by scenario."""
    if (place / CASES).is_file():
        yield from _futures(cases_in(place / CASES, choice.of), read_samples(place / DRIVEN_CASES), choice)
        return
    played = is_round(place)
    if (choice.collisions or choice.driven) and not played:
        raise UnusableInput(
            f"{place} is no round of corner cases, nor an attack: --collisions and --driven are for those, as data/corner/0"
        )
    for shard in _shards(place / SAMPLES if played else place):
        if not holds_samples(shard):
            yield from read_shard(shard)
            continue
        driven = read_samples(place / DRIVEN / shard.name) if played else None
        yield from _futures(futures_in(shard, choice.of), driven, choice)


def _shards(place: Path) -> list[Path]:
    if place.is_file():
        return [place]
    if files := shards(place):
        return files
    if not place.is_dir():
        raise UnusableInput(f"{place} is not there: {_REMEDY}")
    if any(place.glob("scenario_*.parquet")) or any(place.glob("*/scenario_*.parquet")):
        raise UnusableInput(f"{place} is in Argoverse 2's layout already: give a folder of shards, or see docs/python.md")
    raise UnusableInput(f"{place} holds no shard-*.parquet: {within(place) or _REMEDY}")


def _futures(
    of_scenarios: Iterator[tuple[Scenario, Samples]], driven: list[Samples] | None, choice: _Choice
) -> Iterator[Scenario]:
    """Each future of each scenario as a scenario of its own, without the vehicles that it leaves out."""
    for row, (scenario, futures) in enumerate(of_scenarios):
        own = None if driven is None else driven[row]
        for k in range(len(futures.dropped)):
            if choice.collisions and own is not None and not _collided(scenario, futures.motion[k], own, k):
                continue
            traffic = futures.motion[k]
            motion = traffic if own is None or not choice.driven else _with_target(traffic, own.motion[k, TARGET])
            present = np.flatnonzero(motion.valid.any(-1))
            yield replace(
                scenario, scenario_id=sample_id(scenario.scenario_id, k), vehicles=scenario.vehicles[present], log=motion[present]
            )


def _collided(scenario: Scenario, traffic: Trajectories, own: Samples, k: int) -> bool:
    """Whether the target as it was driven in run k of `own` ran into anyone.

    Unless it left the map its run ends there, be it in the last frame, where it would end anyway.
    """
    driven, last = own.motion[k, TARGET], scenario.steps - 1
    if driven.last_valid() < last:
        return not own.left_map[k, TARGET]
    others, people = traffic[TARGET + 1 :], scenario.context
    size = scenario.vehicles.size[:, :2]
    return any(
        bool((boxes_overlap(driven.position[last], driven.heading[last], size[TARGET], at, heading, box) & there).any())
        for at, heading, box, there in (
            (others.position[:, last], others.heading[:, last], size[TARGET + 1 :], others.valid[:, last]),
            (people.motion.position[:, last], people.motion.heading[:, last], people.size[:, :2], people.motion.valid[:, last]),
        )
    )


def _with_target(motion: Trajectories, target: Trajectories) -> Trajectories:
    """`motion` (N, T) with the target moving as `target` (T,) does."""
    changed = motion.copy()
    changed.put(TARGET, target)
    return changed
