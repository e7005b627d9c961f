"""Several drivers in one scene as a recording: neighbours as they were logged, the target once for each driver.

Entities as in `record.py`; further

    world/drivers/NAME     the target as that driver drove it, in the driver's colour
    world/impacts          balls with words where runs ended in a collision
    plots/speed/NAME       its speed; the logged one beside them
"""

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import DT, TARGET, Scenario, Trajectories
from drivegen.core.viewport import window
from drivegen.recording import colours, traffic
from drivegen.recording.blueprint import from_above, playing
from drivegen.recording.lines import flat
from drivegen.recording.record import NARROWEST, WIDEST, recording_of
from drivegen.recording.roads import log_roads, log_signals, surroundings, times

LOGGED = "logged"

_LEGEND = """**Blue**: everybody else, replayed as logged; nobody reacts. **White frame**: the target as it was logged. Each
**other colour** is the target as one driver drives it, from the same start along the same path; a ball marks a collision.

"""


def record_drivers(path: Path, scenario: Scenario, runs: Mapping[str, Trajectories], collided: Collection[str]) -> None:
    """Write the `runs` (T,) of the target by driver in the logged traffic of `scenario`; those who `collided` end with that.

    Raises UnusableInput for a scenario without log: there is nothing to drive through.
    """
    log = scenario.log
    if log is None:
        raise UnusableInput(f"scenario {scenario.scenario_id} has no log to drive through", reason="no-logs")
    shades = dict(zip(runs, colours.drivers(len(runs)), strict=True))
    roads, signals = surroundings(scenario, [log])
    with recording_of(path, f"{scenario.scenario_id}: drivers", _layout(log)) as recording:
        log_roads(recording, roads)
        log_signals(recording, roads, signals)
        _log_others(recording, scenario, log)
        traffic.log_ghosts(recording, "world/logged", scenario.vehicles[TARGET : TARGET + 1], log[TARGET : TARGET + 1])
        traffic.log_context(recording, scenario.context)
        _log_speed(recording, LOGGED, log[TARGET], colours.PLOTTED)
        for name, motion in runs.items():
            shade = np.broadcast_to(np.array(shades[name], np.uint8), (1, motion.steps, 4))
            size, label = scenario.vehicles.size[TARGET : TARGET + 1], np.array([name])
            traffic.log_boxes(recording, f"world/drivers/{name}", motion[np.newaxis], size, shade, label)
            _log_speed(recording, name, motion, shades[name])
        _log_impacts(recording, {name: runs[name] for name in collided})
        words = "\n".join(f"* {name}: {'collision' if name in collided else 'no collision'}" for name in runs)
        recording.log("legend", rr.TextDocument(_LEGEND + words, media_type="text/markdown"), static=True)


def _layout(log: Trajectories) -> rrb.Blueprint:
    scene = from_above(*window(log, NARROWEST, WIDEST), "Scene", "$origin/**")
    legend = rrb.PlotLegend(rrb.Corner2D.RightTop)
    speed = rrb.TimeSeriesView(origin="/plots/speed", name="Speed [m/s]", plot_legend=legend)
    side = rrb.Vertical(speed, rrb.TextDocumentView(origin="/legend", name="Legend"), row_shares=[3, 2])
    return playing(rrb.Horizontal(scene, side, column_shares=[5, 2]))


def _log_others(recording: rr.RecordingStream, scenario: Scenario, log: Trajectories) -> None:
    rows = slice(TARGET + 1, None)
    shades = np.broadcast_to(np.array(colours.SOCIAL, np.uint8), (*log[rows].valid.shape, 4))
    traffic.log_boxes(
        recording, "world/traffic", log[rows], scenario.vehicles.size[rows], shades, scenario.vehicles.track_id[rows]
    )


def _log_speed(recording: rr.RecordingStream, name: str, motion: Trajectories, shade: colours.Colour) -> None:
    steps, path = np.flatnonzero(motion.valid), f"plots/speed/{name}"
    recording.log(path, rr.SeriesLines(colors=[shade], names=[name], widths=[2.0]), static=True)
    recording.send_columns(path, indexes=times(steps), columns=rr.Scalars.columns(scalars=motion.speed[steps]))


def _log_impacts(recording: rr.RecordingStream, runs: Mapping[str, Trajectories]) -> None:
    for name, motion in runs.items():
        step = int(motion.last_valid())
        ball = rr.Points3D.from_fields(colors=[colours.ILLEGAL], radii=0.8, show_labels=True)
        recording.log(f"world/impacts/{name}", ball, static=True)
        place = rr.Points3D.columns(positions=flat(motion.position[step][None], 2.5), labels=[f"{name}, {step * DT:.1f} s"])
        recording.send_columns(f"world/impacts/{name}", indexes=times(np.array([step])), columns=place)


def speeds(motion: Trajectories) -> list[float | None]:
    """Those of `motion` (T,) [m/s], to the centimetre, until it ends; None where nobody saw it."""
    steps = range(int(motion.last_valid()) + 1)
    return [round(float(motion.speed[step]), 2) if motion.valid[step] else None for step in steps]
