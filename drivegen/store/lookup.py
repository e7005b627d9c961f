"""A scenario by its id, and with its futures, out of the folders in which the pipeline leaves shards."""

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import read_shard, shards

_Row = TypeVar("_Row", Scenario, Samples)

CASES, DRIVEN_CASES = "samples.parquet", "driven.parquet"
"""Of the folder of an attack: its cases, of some scenarios only, one future each; the targets alone, as they were driven."""

SAMPLES, DRIVEN = "samples", "driven"
"""Folders in that of a round of corner cases: its traffic; the targets alone, as they were driven."""

_SAMPLE = re.compile(r"(.+)-s(\d{2,})")


def find_scenario(name: str, folders: Sequence[Path]) -> tuple[Path, Scenario] | None:
    """The first scenario of that id (folders' names have dashes for colons: both forms count) and its shard; None without one."""
    for shard in (shard for folder in folders for shard in shards(folder)):
        ids = ids_in(shard)
        for row, scenario_id in enumerate(ids):
            if name in (scenario_id, scenario_id.replace(":", "-")):
                return shard, read_shard(shard)[row]
    return None


def find_sample(name: str, folders: Sequence[Path], generated: Path) -> tuple[Scenario, Samples, int] | None:
    """A future `<id>-s<number>`: its scenario, its samples in shards or CASES of `generated`, its number; None without one."""
    parts = _SAMPLE.fullmatch(name)
    place = find_scenario(parts[1], folders) if parts else None
    if parts is None or place is None:
        return None
    shard, scenario = place
    places = [file for file in (generated / shard.name, generated / CASES) if file.is_file()]
    files = [file for file in places if scenario.scenario_id in ids_in(file)]
    if not files:
        for damaged in (file for file in places if not ids_in(file)):
            samples_in(damaged, scenario.scenario_id)  # raises, and says what is wrong with it
        return None
    samples = samples_in(files[0], scenario.scenario_id)
    number = int(parts[2])
    return (scenario, samples, number) if number < len(samples.dropped) else None


def is_round(folder: Path) -> bool:
    """Whether a folder is a round of corner cases."""
    return (folder / SAMPLES).is_dir() and (folder / DRIVEN).is_dir()


def traffic_files(folder: Path) -> list[Path]:
    """The shards of a folder, those of the traffic of a round of corner cases, or the cases of an attack; [] without any."""
    place = folder / SAMPLES if is_round(folder) else folder
    return shards(place) or [file for file in (place / CASES,) if file.is_file()]


def ids_in(shard: Path) -> list[str]:
    """Ids of a shard's scenarios, in order; an empty list where the file is not whole.

    Reading it as scenarios would say so, and another shard may have what is wanted.
    """
    try:
        ids: list[str] = pq.read_table(shard, columns=["scenario_id"])["scenario_id"].to_pylist()
    except (pa.ArrowException, OSError):
        return []
    return ids


def scenario_in(shard: Path, scenario_id: str) -> Scenario:
    """That scenario of a shard; raises UnusableInput where the shard lacks it."""
    return _only(shard, read_shard(shard), scenario_id)


def samples_in(shard: Path, scenario_id: str) -> Samples:
    """The futures of that scenario in a shard of samples; raises UnusableInput where the shard lacks it."""
    return _only(shard, read_samples(shard), scenario_id)


def logs_in(shard: Path) -> list[tuple[Scenario, Trajectories]]:
    """Each scenario of a shard that has a log, with it."""
    return [(scenario, scenario.log) for scenario in read_shard(shard) if scenario.log is not None]


def logs_below(folder: Path) -> list[tuple[Scenario, Trajectories]]:
    """Those of all shards of a folder; raises UnusableInput where there are none."""
    logs = [one for shard in shards(folder) for one in logs_in(shard)]
    if not logs:
        raise UnusableInput(f"{folder} holds no scenario with a log to learn from", reason="no-scenarios")
    return logs


def futures_in(shard: Path, scenarios: Path) -> Iterator[tuple[Scenario, Samples]]:
    """Each scenario of a shard of samples with its futures, in order; `scenarios` is the folder of their scenarios' shards.

    Raises UnusableInput where that folder lacks the shard, or has other scenarios in it.
    """
    base = scenarios / shard.name
    if not base.is_file():
        raise UnusableInput(f"{shard} holds futures of scenarios in {base}, which is not there: name their folder")
    rows, futures = read_shard(base), read_samples(shard)
    if [row.scenario_id for row in rows] != [samples.scenario_id for samples in futures]:
        raise UnusableInput(f"{shard} holds futures of other scenarios than {base}: name their folder, or make them again")
    yield from zip(rows, futures, strict=True)


def cases_in(file: Path, scenarios: Path) -> Iterator[tuple[Scenario, Samples]]:
    """Each case of a file CASES with its scenario, in order; `scenarios` is the folder of all scenarios' shards.

    Raises UnusableInput where that folder lacks one.
    """
    cases = read_samples(file)
    wanted = {case.scenario_id for case in cases}
    holding = [shard for shard in shards(scenarios) if wanted.intersection(ids_in(shard))]
    found = {scenario.scenario_id: scenario for shard in holding for scenario in read_shard(shard)}
    if unknown := wanted - found.keys():
        raise UnusableInput(f"{file} holds a case of scenario {min(unknown)}, which is not in {scenarios}: name their folder")
    yield from ((found[case.scenario_id], case) for case in cases)


def first_futures(folder: Path, scenarios: Path, count: int) -> list[tuple[Scenario, Trajectories]]:
    """The first `count` futures of each scenario of all shards of a folder; `scenarios` as in `futures_in`.

    Raises UnusableInput where a scenario has fewer.
    """
    futures = [pair for shard in shards(folder) for pair in futures_in(shard, scenarios)]
    fewest = min((len(made.dropped) for _, made in futures), default=count)
    if fewest < count:
        raise UnusableInput(f"{folder} holds {fewest} futures of a scenario, {count} are wanted: make more of them")
    return [(scenario, made.motion[k]) for scenario, made in futures for k in range(count)]


def in_turn(scenarios: Path, samples: Path | None, most: int) -> list[tuple[Scenario, Trajectories, int]]:
    """Traffic of a shard of scenarios: the log of each (0), or the first future of each (0), then the second of each (1), ...

    `most` of it; where that is less than one of each scenario, these are spread over the shard.
    """
    if samples is None:
        found = [(scenario, log, 0) for scenario, log in logs_in(scenarios)]
    else:
        futures = list(futures_in(samples, scenarios.parent))
        deep = max((len(made.dropped) for _, made in futures), default=0)
        found = [(scenario, made.motion[k], k) for k in range(deep) for scenario, made in futures if k < len(made.dropped)]
    first = sum(turn == 0 for *_, turn in found)
    return [found[n] for n in evenly(first, most)] if most < first else found[:most]


def evenly(count: int, most: int) -> list[int]:
    """At most so many numbers below `count`, spread over them; all where `most` is as many."""
    return [n * count // min(most, count) for n in range(min(most, count))]


def shared(total: int, sizes: Sequence[int]) -> list[int]:
    """`total` shared out in proportion to `sizes`, none of which may be negative; nothing is lost in rounding."""
    ends = [round(total * sum(sizes[:n]) / max(sum(sizes), 1)) for n in range(len(sizes) + 1)]
    return [end - begin for begin, end in pairwise(ends)]


def _only(shard: Path, rows: "Sequence[_Row]", scenario_id: str) -> "_Row":
    for row in rows:
        if row.scenario_id == scenario_id:
            return row
    raise UnusableInput(f"{shard} lacks scenario {scenario_id}: make it again (`dvc repro`)")
