"""One scene by every method side by side: a Rerun recording with a view for each, all on one clock.

Entities (frames and time lines as in `record.py`):

    world/roads/*, world/signals   shared by all views, as are people and cyclists, world/context
    world/methods/NAME/samples     the lines of all samples of a method, red where the checker objects
    world/methods/NAME/goals       the places that the samples of a method follow, where it has goals
    world/methods/NAME/rejected    dashed: what the checker turned down and the method planned again
    world/methods/NAME/traffic     the vehicles of one sample, moving; the log has a view of its own
    legend                         what the lines are, and how many were turned down for which reason
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from drivegen.core.rejections import Rejected
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.core.viewport import window
from drivegen.recording import colours
from drivegen.recording.blueprint import from_above, playing
from drivegen.recording.lines import flat, log_rejected, thinned
from drivegen.recording.record import NARROWEST, WIDEST, recording_of
from drivegen.recording.roads import log_roads, log_signals, surroundings
from drivegen.recording.traffic import log_boxes, log_context

LOG = "log"
_SHARED = ("/world/roads/**", "/world/signals", "/world/context")
_FAINT = 90
_NEAR_ENOUGH = 0.3
"""Samples' lines are drawn this exactly [m]: a view has hundreds, all faint."""


def record_comparison(
    path: Path,
    scenario: Scenario,
    methods: Mapping[str, Samples],
    goals: Mapping[str, NDArray[np.float32]],
    rejected: Mapping[str, Rejected],
) -> None:
    """Write `scenario` with the samples of `methods` by name, the first of each moving; its log first, if it has one.

    `goals` (C, 2) [m], by name, are the places that samples follow; methods without goals have none. `rejected`, by name, is
    what was turned down and replaced; methods that plan nothing again have none.
    """
    logs = {} if scenario.log is None else {LOG: scenario.log}
    moving = {**logs, **{name: samples.motion[0] for name, samples in methods.items()}}
    centre, extent = window(next(iter(moving.values())), NARROWEST, WIDEST)
    views = [from_above(centre, extent, name, [*_SHARED, f"/world/methods/{name}/**"]) for name in moving]
    show = playing(rrb.Grid(*views, rrb.TextDocumentView(origin="/legend", name="Legend")))
    roads, signals = surroundings(scenario, list(moving.values()))
    with recording_of(path, f"{scenario.scenario_id}: methods side by side", show) as recording:
        log_roads(recording, roads)
        log_signals(recording, roads, signals)
        log_context(recording, scenario.context)
        for name, motion in moving.items():
            _log_traffic(recording, f"world/methods/{name}/traffic", scenario, motion)
        for name, samples in methods.items():
            _log_samples(recording, f"world/methods/{name}/samples", samples)
        for name, places in goals.items():
            points = rr.Points3D(flat(places, 0.2), colors=[colours.CHOSEN], radii=0.5)
            recording.log(f"world/methods/{name}/goals", points, static=True)
        for name, rejections in rejected.items():
            log_rejected(recording, f"world/methods/{name}/rejected", rejections)
        recording.log("legend", rr.TextDocument(_legend(rejected), media_type="text/markdown"), static=True)


def _log_traffic(recording: rr.RecordingStream, path: str, scenario: Scenario, motion: Trajectories) -> None:
    count = len(scenario.vehicles)
    shades = np.array([colours.TARGET] + [colours.SOCIAL] * (count - 1), np.uint8)
    shades = np.broadcast_to(shades[:, None], (count, motion.steps, 4))
    log_boxes(recording, path, motion, scenario.vehicles.size, shades, scenario.vehicles.track_id)


def _log_samples(recording: rr.RecordingStream, path: str, samples: Samples) -> None:
    """Lines of all samples of all vehicles, as exact as a faint line needs."""
    lines, shades = [], []
    for k, i in np.ndindex(*samples.violation.shape):
        legal = colours.TARGET if i == TARGET else colours.SOCIAL
        for line in samples.motion[k, i].stretches():
            if len(line) > 1:
                lines.append(flat(thinned(line, _NEAR_ENOUGH), 0.02))
                shades.append((*(legal if samples.legal[k, i] else colours.ILLEGAL)[:3], _FAINT))
    recording.log(path, rr.LineStrips3D(lines, colors=shades, radii=0.1), static=True)


def _legend(rejected: Mapping[str, Rejected]) -> str:
    explanation = (
        "**Lines** are all samples over one another: orange the target's, blue the others', red what the checker objects to and "
        "stays. **Green**: people and cyclists. **Violet points**: the goals that samples follow. **Thin pale dashes**: planned, "
        "turned down by the checker and replaced, in all samples. Only DriveGen and its ablations plan again; of the other "
        "methods everything stays."
    )
    counts = [f"* {name}: {rejections.summary}" for name, rejections in rejected.items()]
    return "\n".join([explanation, "", *counts])
