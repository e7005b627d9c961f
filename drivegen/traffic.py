"""One scenario from what a user has: a logged scene or a road network in, K futures of its traffic out, as folders.

Paper, section III: initialisation (the logged first frame, or vehicles placed on a map), then rollout. Regenerated traffic
is scored against its log, so nobody is left out of it. New traffic has no log: what could not be made legal is left out,
and a future without its target is no scenario; both are counted in its row.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from drivegen.asked.account import Item, first_frame, manoeuvres
from drivegen.asked.start import AskedStart
from drivegen.asked.start import Settings as AskedSettings
from drivegen.asked.start import start as asked_start
from drivegen.av2.export import export_scenario
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.samples import Samples, Violation
from drivegen.core.scenario import Scenario
from drivegen.generators.base import Settings
from drivegen.goals.packing import pack
from drivegen.ingest.selection import Settings as SelectionSettings
from drivegen.ingest.selection import select
from drivegen.metrics.displacement import scene_errors
from drivegen.metrics.safety import COLLISIONS
from drivegen.placement.gaps import Gaps
from drivegen.placement.scenes import Initialiser
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.placement.table import Table
from drivegen.recording.sample import record_sample
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import choose
from drivegen.rollout.models import Equipment
from drivegen.rollout.shipping import ShipSettings, rejection, sample_id
from drivegen.store.goals import GoalColumns
from drivegen.sumo.network import Network
from drivegen.words.request import TrafficRequest

METHOD, SELECTOR = "drivegen", "learned"

_ANY_TARGET = ShipSettings(fewest=1, moved=0.0)
"""Whoever asks for one scenario gets it, however few vehicles are in it and however little its target moves."""


def _nothing(_: AskedStart) -> Sequence[Item]:
    return ()


@dataclass(frozen=True)
class Start:
    """Who stands where at the first frame.

    Attributes:
        scenario: map, vehicles, context, signals; with the log if there is one.
        left_out: vehicles that are not in it though they were asked for or recorded, by reason.
        asked: the traffic as it was asked for in words, with the goals that realise its manoeuvres.
        told: what was asked for of a first frame, and whether it is got there.
    """

    scenario: Scenario
    left_out: Mapping[str, int]
    asked: AskedStart | None = None
    told: Callable[[AskedStart], Sequence[Item]] = _nothing

    @property
    def got(self) -> list[Item]:
        """What was got of the first frame with all who were placed."""
        return [] if self.asked is None else list(self.told(self.asked))


@dataclass(frozen=True)
class Traffic:
    """K futures of a start.

    Attributes:
        goals: every vehicle's candidates, and the probabilities with which they were drawn.
        goals_by: who chose among them, in words.
    """

    start: Start
    samples: Samples
    goals: GoalColumns
    goals_by: str

    def __len__(self) -> int:
        return len(self.samples.dropped)


def from_log(log: RecordedLog, settings: SelectionSettings) -> Start:
    """The first frame of a recording. Raises UnusableInput where it yields no scenario (see `select`)."""
    scenario = select(log, settings)
    words = ("overlapping", "implausible")
    counts = {word: int(scenario.notes.get(f"dropped_{word}", 0)) for word in words}
    return Start(scenario, {word: count for word, count in counts.items() if count})


def from_network(
    network: Network,
    name: str,
    source: str,
    table: Table,
    settings: InitialSettings,
    seed: int,
    gaps: Gaps | None = None,
    beset: bool = False,
) -> Start:
    """Vehicles of the table placed on a network, its signals by their programs; `gaps` are for placement as in logs.

    If `beset`, they stand around the target first: beside, before, behind and across its way.

    Raises UnusableInput where not even the target finds a place.
    """
    scenario, rejected = Initialiser(network, name, source, table, settings, gaps).scenario(0, seed, beset)
    return Start(scenario, rejected)


def from_words(
    initialiser: Initialiser,
    request: TrafficRequest,
    how: AskedSettings,
    vehicles: int,
    tools: Equipment,
    settings: Settings,
    seed: int,
) -> Start:
    """The traffic of a request on the initialiser's network; `vehicles` in all where the request does not say how many.

    Raises UnusableInput where not even the target finds a place.
    """
    first = asked_start(initialiser, initialiser.scenario_id(0, seed), request, how, vehicles, tools.selector, settings, seed)
    return Start(first.scenario, first.rejected, first, partial(first_frame, request, densities=how.densities))


def make(start: Start, tools: Equipment, settings: Settings, samples: int, seed: int) -> Traffic:
    """K = `samples` futures of `start`, judged by the checker; depends on the start and the seed alone.

    Raises UnusableInput, reason `no-legal-target`, where no future is a scenario.
    """
    if start.asked is not None:
        choices = [start.asked.ordered.choices]
    else:
        choices = choose([start.scenario], tools.selector, settings.candidates, settings.temperature)
    futures = roll_out(choices, tools.planner, tools.limits, settings.rollout, samples, seed, METHOD)[0]
    goals = pack(start.scenario, SELECTOR, choices[0].candidates, choices[0].used)
    bound = start.asked is not None and any(start.asked.ordered.feasible)
    traffic = Traffic(start, futures, goals, f"{tools.selector.described}, bound by words" if bound else tools.selector.described)
    if all(rejected(traffic, k) for k in range(samples)):
        raise UnusableInput(
            f"no legal traffic was found in {samples} samples ({rejected(traffic, 0)}): try another seed or more samples",
            reason="no-legal-target",
        )
    return traffic


def rejected(traffic: Traffic, k: int) -> str | None:
    """Why sample k is no scenario; None if it is one, as all are that are scored against a log."""
    return None if traffic.start.scenario.log is not None else rejection(traffic.samples, k, _ANY_TARGET)


def write_sample(traffic: Traffic, k: int, folder: Path) -> None:
    """Sample k as `folder/<id>`: the official layout, and the recording beside it. Nothing where it is no scenario."""
    if rejected(traffic, k):
        return
    scenario = traffic.start.scenario
    name = sample_id(scenario.scenario_id, k)
    place = export_scenario(scenario, traffic.samples.motion[k], folder, name)
    record_sample(place / f"{name}.rrd", scenario, traffic.samples, k, traffic.goals)


def row(traffic: Traffic, k: int) -> dict[str, Any]:
    """What is to be said of sample k; errors in metres, everything else counts vehicles.

    `id` (null where `rejected` says why there is no scenario), `sade` and `sfde` (null without a log), `vehicles` at the
    first frame, `not_placed` by reason (not there from the beginning), `dropped` (nothing legal was found), and of the
    others `illegal`, `colliding`, `off_road` and `violations` by kind. `asked` where words asked for traffic.
    """
    scenario, samples = traffic.start.scenario, traffic.samples
    flags = samples.violation[k][~samples.dropped[k]]
    reason = rejected(traffic, k)
    kinds = [kind for kind in Violation if kind is not Violation.NONE]
    violations = {str(kind.name).lower(): int(((flags & int(kind)) > 0).sum()) for kind in kinds}
    return {
        "id": None if reason else sample_id(scenario.scenario_id, k),
        "rejected": reason,
        "sample": k,
        "source": scenario.source,
        "method": samples.method,
        "goals_by": traffic.goals_by,
        "vehicles": len(scenario.vehicles),
        "not_placed": dict(traffic.start.left_out),
        "dropped": int(samples.dropped[k].sum()),
        "illegal": int((flags > 0).sum()),
        "colliding": int(((flags & int(COLLISIONS)) > 0).sum()),
        "off_road": violations["off_road"],
        "violations": {kind: count for kind, count in violations.items() if count},
        "notes": scenario.notes,
        **_errors(traffic, k),
        **_asked(traffic, k),
    }


def _asked(traffic: Traffic, k: int) -> dict[str, Any]:
    """`asked`: one {kind, what, got, natural} for each thing that the words asked for; nothing without words.

    Whom a future leaves out is not in its scenario, so nothing that was asked for of that vehicle is got.
    """
    start = traffic.start
    if start.asked is None:
        return {}
    present = np.flatnonzero(~traffic.samples.dropped[k])
    achieved = start.got if rejected(traffic, k) else start.told(start.asked.only(present))
    items = [*achieved, *manoeuvres(start.asked, traffic.samples, k)]
    return {"asked": [asdict(item) for item in items]}


def _errors(traffic: Traffic, k: int) -> dict[str, float | None]:
    log = traffic.start.scenario.log
    if log is None:
        return {"sade": None, "sfde": None}
    sade, sfde = scene_errors(traffic.samples.motion[k : k + 1], log)
    return {"sade": float(sade[0]), "sfde": float(sfde[0])}
