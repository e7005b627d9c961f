"""Scenarios with traffic from a folder: shards or samples that drivegen wrote, or Argoverse 2 scenarios."""

import warnings
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from drivegen.av2.folder import read_folder
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.drivers.shared.conditions import Traffic
from drivegen.ingest.selection import Settings, select
from drivegen.store.lookup import CASES, cases_in, futures_in, traffic_files
from drivegen.store.samples import holds_samples
from drivegen.store.scenarios import read_shard

SELECTION = Settings(target="focal", max_vehicles=1000, first_step=0, horizon=20_000, map_radius=None, smallest_shrink=0.8)
"""How an Argoverse 2 recording becomes a scenario: with all of its vehicles and steps."""

SCENES = Path("data/scenarios/test")
"""What samples hold futures of, where nothing else is said."""

_REMEDY = "give one with shards, as data/shipped, or with Argoverse 2 scenarios"


def read_traffic(folder: Path, of: Path = SCENES) -> list[Traffic]:
    """As `read_futures`, without their numbers."""
    return [(scenario, motion) for scenario, _, motion in read_futures(folder, of)]


def read_futures(folder: Path, of: Path = SCENES) -> list[tuple[Scenario, int, Trajectories]]:
    """Every scenario of a folder with 0 and its log, or with number and motion of each of its futures.

    `folder` holds shards of scenarios or of samples (`of` has their scenarios), is a round of corner cases, what one adversary
    found against a driver, one Argoverse 2 scenario, or a folder of those. What nobody can drive in is left out with a warning
    that counts the reasons, with the first of each in words. Raises UnusableInput where nothing remains, or where two have one
    id: whoever reads keeps them by it.
    """
    if not folder.is_dir():
        in_project = folder.parts[:1] == SCENES.parts[:1] and not folder.exists()
        made = "run `make run` first, in the project's folder, or " if in_project else ""
        raise UnusableInput(f"{folder} is no folder: {made}{_REMEDY}")
    files = traffic_files(folder)
    left_out: dict[str, list[str]] = defaultdict(list)
    usable, found = [], dict[tuple[str, int], Path]()
    for file in files or _argoverse2(folder):
        for scenario, number, motion in _of_shard(file, of, left_out) if files else _of_folder(file, left_out):
            if (other := found.get((scenario.scenario_id, number))) is not None:
                raise UnusableInput(_twice(scenario.scenario_id, other, file))
            found[scenario.scenario_id, number] = file
            if motion.valid[TARGET, :2].all():
                usable.append((scenario, number, motion))
            else:
                left_out["no-target"].append(scenario.scenario_id)
    reasons = ", ".join(f"{len(which)} {reason} ({which[0]})" for reason, which in sorted(left_out.items()))
    if not usable:
        why = reasons or ("its shards are empty" if files else "neither shard-*.parquet nor scenario_*.parquet is there")
        raise UnusableInput(f"{folder} holds no scenario with traffic and a target to drive ({why}): {within(folder) or _REMEDY}")
    if reasons:
        warnings.warn(f"{folder}: scenarios left out: {reasons}", stacklevel=2)
    return usable


def within(folder: Path) -> str:
    """What to give in place of a folder that holds nothing itself: one in it that has shards or cases; "" without one."""
    holding = sorted(place for place in folder.iterdir() if traffic_files(place))
    return f"give a folder in it, as {holding[0]}" if holding else ""


def _twice(scenario_id: str, one: Path, other: Path) -> str:
    places = (
        f"{one} holds scenario {scenario_id} twice" if one == other else f"{one} and {other} both hold scenario {scenario_id}"
    )
    return f"{places}: take one away, or generate it anew with another --seed or from a map of another name (ids begin with it)"


def _of_shard(shard: Path, of: Path, left_out: dict[str, list[str]]) -> Iterator[tuple[Scenario, int, Trajectories]]:
    if not holds_samples(shard):
        for scenario in read_shard(shard):
            if scenario.log is None:
                left_out["no-motion"].append(scenario.scenario_id)
            else:
                yield scenario, 0, scenario.log
        return
    for scenario, samples in cases_in(shard, of) if shard.name == CASES else futures_in(shard, of):
        yield from ((scenario, k, samples.motion[k]) for k in range(len(samples.dropped)))


def _argoverse2(folder: Path) -> list[Path]:
    """The folder of one scenario itself, or all of scenarios in it, also of its splits."""
    single = any(folder.glob("scenario_*.parquet"))
    return [folder] if single else sorted({file.parent for file in folder.glob("**/scenario_*.parquet")})


def _of_folder(folder: Path, left_out: dict[str, list[str]]) -> Iterator[tuple[Scenario, int, Trajectories]]:
    """Its scenario; what is not usable by reason, in words."""
    try:
        scenario = select(read_folder(folder, "Argoverse 2 Motion Forecasting"), SELECTION)
    except UnusableInput as error:
        left_out[error.reason].append(str(error))
        return
    assert scenario.log is not None
    yield scenario, 0, scenario.log
