"""A thousand new scenarios from placement to written shards, 16 vehicles and 10 samples each, by the models that `make run` made.

Nothing is averaged away: who is illegal is planned again as when shipping, so the figure depends on what models were trained.
Memory is that of processes of their own, which make one shard and four of them, as stages do: the peak should not grow.
"""

import multiprocessing
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from drivegen.bench import _scene
from drivegen.bench._row import Row
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.placement.place import PlaceSettings
from drivegen.placement.scenes import Initialiser
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.placement.table import build_table
from drivegen.roads.reach import Dynamics
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import choose
from drivegen.rollout.models import Equipment
from drivegen.rollout.scene import RolloutSettings
from drivegen.rollout.shipping import ShipSettings, ship
from drivegen.store.scenarios import write_shard
from drivegen.sumo.network import Network

MODELS = Path("data/models")
NEEDS = (MODELS / "planners" / "route_fm", MODELS / "selector", MODELS / "limits.json")

SCENES, VEHICLES, SAMPLES = 48, 16, 10
MORE = 4
_PLACING = PlaceSettings(
    mode="paper", road_ahead=120.0, radius=80.0, speed_spread=0.15, least_time_gap=0.8, standstill_gap=2.0, attempts=24
)
_CANDIDATES = CandidateSettings(
    most=32, most_routes=12, spacing=2.6, dynamics=Dynamics(acceleration=3.0, braking=4.5, lateral=5.0, limit_factor=1.25)
)
_SHIPPED = ShipSettings(fewest=1, moved=0.0)
_TEMPERATURE = 0.45
_ROLLOUT = RolloutSettings(attempts=4, rounds=5, evictions=2, drop_illegal=True, target_steps=None, exclusion=True, tempo=0.8)

Result = TypeVar("Result")


@dataclass
class _Clock:
    """CPU seconds by step; a step inside another one is taken off it."""

    spent: dict[str, float] = field(default_factory=dict)
    inner: float = 0.0

    def time(self, step: str, work: Callable[..., Result]) -> Callable[..., Result]:
        """`work`, its time added to `step`."""

        def timed(*values: Any, **named: Any) -> Result:
            before, self.inner, began = self.inner, 0.0, time.process_time()
            result = work(*values, **named)
            whole = time.process_time() - began
            self.spent[step] = self.spent.get(step, 0.0) + whole - self.inner
            self.inner = before + whole
            return result

        return timed


def rows() -> Iterator[Row]:
    """120 CPU-seconds a thousand scenarios, one crossing in four ways; then where they go."""
    tools, initialisers = _open()
    _run(initialisers, tools, range(8), _Clock())  # compiles
    clock = _Clock()
    _run(initialisers, tools, range(SCENES), clock)
    per_thousand = {step: seconds / SCENES * 1e3 for step, seconds in clock.spent.items()}
    unit = "CPU-seconds per 1000 scenarios"
    yield Row(
        f"generation, {VEHICLES} x {SAMPLES} samples, from placement to shards", sum(per_thousand.values()), unit, 120.0, True
    )
    for step, seconds in per_thousand.items():
        yield Row(f"of it: {step}", seconds, unit, None, True)
    one, more = _peak_megabytes(1), _peak_megabytes(MORE)
    yield Row(f"generation, peak memory of {MORE} shards of {SCENES} scenes", more, "MB", None, True, one, "of one shard")


def _peak_megabytes(shards: int) -> float:
    """Peak memory of a process that makes so many shards, one after the other."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(_peak_memory, shards).result()


def _peak_memory(shards: int) -> float:
    """Make the shards; this process's peak memory [MB]. Not getrusage's, which a child begins with its parent's."""
    tools, initialisers = _open()
    for shard in range(shards):
        _run(initialisers, tools, range(shard * SCENES, (shard + 1) * SCENES), _Clock())
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:")) / 1024


def _open() -> tuple[Equipment, list[Initialiser]]:
    controls = ("signals", "stop", "yield", "uncontrolled")
    return Equipment.open(MODELS, "route_fm", "learned"), [_initialiser(control) for control in controls]


def _initialiser(control: str) -> Initialiser:
    road = {
        "kind": "crossing",
        "control": control,
        "arms": [{"angle": a, "lanes_in": 2, "lanes_out": 2} for a in (0, 90, 180, 270)],
    }
    network = Network.read(compile_map(MapSpec.model_validate({"road": road})), "benchmark crossing")
    table = build_table([_scene.scene(number) for number in range(8)])
    settings = InitialSettings(VEHICLES, _scene.STEPS - 1, {"car": 1.0}, 250.0, _PLACING)
    return Initialiser(network, control, "benchmark", table, settings)


def _run(initialisers: Sequence[Initialiser], tools: Equipment, numbers: Iterable[int], clock: _Clock) -> None:
    place = clock.time("placement", lambda number: initialisers[number % 4].scenario(number, _scene.SEED)[0])
    scenarios = [place(number) for number in numbers]
    _generate(scenarios, tools, clock)


def _generate(scenarios: list[Scenario], tools: Equipment, clock: _Clock) -> None:
    selector, planner = copy(tools.selector), copy(tools.planner)
    selector.rank = clock.time("ranking goals", selector.rank)  # type: ignore[method-assign]
    planner.sample = clock.time("planning", planner.sample)  # type: ignore[method-assign]
    choices = clock.time("routes and candidates", choose)(scenarios, selector, _CANDIDATES, _TEMPERATURE)
    futures = clock.time("drawing goals, checking, committing", roll_out)(
        choices, planner, tools.limits, _ROLLOUT, SAMPLES, _scene.SEED, "drivegen"
    )
    clock.time("writing", _write)(scenarios, futures)


def _write(scenarios: list[Scenario], futures: list[Samples]) -> None:
    counts: Counter[str] = Counter()
    shipped = [one for s, samples in zip(scenarios, futures, strict=True) for one in ship(s, samples, _SHIPPED, counts)]
    with tempfile.TemporaryDirectory() as folder:
        write_shard(Path(folder) / "shard-00000.parquet", shipped)
