"""Stage drive_tuned: how tuned drivers do on test scenes, among replayed neighbours and among those that react.

argv: scenarios of one split, policies (folder <driver>/<seed>/<method>), results (Parquet rows by scenario; metrics
among reactive neighbours begin with "reactive."), diversity (JSON, with intervals over recordings).
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import percentiles, recording, resamplings
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.core.seeds import rng
from drivegen.core.settings import Count
from drivegen.metrics.driving import NEIGHBOURS, run_numbers, spread_over_runs
from drivegen.metrics.near_miss import rich_in_encounters
from drivegen.store.files import write_json
from drivegen.store.lookup import logs_in
from drivegen.store.results import Run, result_rows, write_results
from drivegen.store.scenarios import shards
from drivegen.world.outcome import DrivingOutcome, with_off_road
from drivegen.world.reactive import Reaction
from stages._door import require, spread

SIMULATOR = "batch"
Numbers = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Params:
    """`draws` bootstrap draws; `reaction` of neighbours; `policies`: the folder of them, of this run or of another one."""

    seed: int
    workers: Count
    draws: Count
    policies: str
    reaction: Reaction


def main(params: Params, scenarios: Path, policies: Path, results: Path, diversity: Path) -> dict[str, float]:
    """Every policy in every scene."""
    folders = sorted(path.parent for path in require(policies, "run the stage tune").glob("*/*/*/settings.json"))
    chosen = tuple((folder.parts[-3], str(folder)) for folder in folders)
    files, work = shards(require(scenarios, "run the ingest stage")), partial(_drive_shard, chosen, params.reaction)
    parts = [part for _, part in spread(work, files, params.workers, "drive_tuned") if part[0]]
    if not parts:
        raise UnusableInput(f"{scenarios} holds no scenario with a log to drive through", reason="no-scenarios")
    ids = [name for part in parts for name in part[0]]
    spreads, tables = {}, list[pa.Table]()
    for number, folder in enumerate(folders):
        driver, seed, method = folder.parts[-3:]
        own, inputs = {**asdict(params), "seed": int(seed)}, [scenarios, folder]
        run = Run.of("drive_tuned", results.stem, own, inputs, method=method, driver=driver, backend=SIMULATOR)
        numbers = [part[1][number] for part in parts]
        tables.append(result_rows(run, ids, {key: np.concatenate([one[key] for one in numbers]) for key in numbers[0]}))
        for kind, neighbours in enumerate(NEIGHBOURS):
            motion = Trajectories.joined([part[2][number][kind] for part in parts])
            spreads[f"{driver}/{method}/{seed}/{neighbours}"] = _spread(motion, ids, params)
    write_results(results, tables)
    write_json(diversity, spreads)
    return {"runs": 2.0 * len(ids) * len(folders)}


def _spread(motion: Trajectories, ids: Sequence[str], params: Params) -> dict[str, float]:
    """Div over all runs, with its interval over recordings."""
    resampled = resamplings([recording(name) for name in ids], params.draws, rng(params.seed, "drive_tuned"))
    value, *draws = spread_over_runs(motion, np.concatenate([np.ones((1, len(ids))), resampled]))
    ends = percentiles(np.array([draw for draw in draws if np.isfinite(draw)]))
    return dict(zip(("value", "low", "high"), (float(value), *ends), strict=True))


def _drive_shard(
    policies: Sequence[tuple[str, str]], reaction: Reaction, shard: Path
) -> tuple[list[str], list[Numbers], list[list[Trajectories]]]:
    """Ids (S,), and of each policy, a driver's name and weights, its numbers (S,) and motion among either kind of neighbours."""
    traffic = logs_in(shard)
    if not traffic:
        return [], [], []
    scenarios, logs = [scenario for scenario, _ in traffic], [log for _, log in traffic]
    how = {"sees_rules": True}
    drivers = [plugins.make("drivers", name, {name: {"weights": w, **how}}, "drive_tuned") for name, w in policies]
    simulator = plugins.load("simulators", SIMULATOR)
    worlds = [simulator(reaction=law, counts_lights=True) for law in (None, reaction)]
    kinds = [world.run_each(drivers, scenarios, logs) for world in worlds]
    shared = {
        "rich": rich_in_encounters(scenarios, logs).astype(float),
        "logged": np.array([run_numbers(log[[TARGET]]).distance[0] for log in logs]),
    }
    numbers = [shared.copy() for _ in drivers]
    for prefix, outcomes in zip(NEIGHBOURS.values(), kinds, strict=True):
        for row, outcome in zip(numbers, outcomes, strict=True):
            row |= {f"{prefix}{key}": value for key, value in _numbers(outcome, scenarios).items()}
    return [s.scenario_id for s in scenarios], numbers, [[kind[n].motion for kind in kinds] for n in range(len(drivers))]


def _numbers(outcome: DrivingOutcome, scenarios: Sequence[Scenario]) -> Numbers:
    runs = run_numbers(outcome.motion)
    return {
        "cr": outcome.collided,
        "counted": outcome.counted,
        "dis": runs.distance,
        "absolute_acceleration": runs.absolute_acceleration,
        "acceleration": runs.acceleration,
        "off_road": with_off_road(outcome, scenarios).off_road,
        "imposed_braking": outcome.imposed_braking,
    } | {"red_lights": outcome.red_lights, "red_run": outcome.red_run}
