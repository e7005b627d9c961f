"""A driver's collision as a recording: the target as it was driven and as it was planned, who it met, and the impact marked.

Entities as in `record.py`; further

    world/planned    the target as it was planned, as a wire frame
    world/impact     a ball with words where the boxes met, from the impact on
"""

from pathlib import Path

import numpy as np
import rerun as rr

from drivegen.core.samples import Samples
from drivegen.core.scenario import DT, TARGET, Scenario, Trajectories
from drivegen.core.viewport import window
from drivegen.recording import colours, traffic
from drivegen.recording.blueprint import layout
from drivegen.recording.lines import flat
from drivegen.recording.record import NARROWEST, WIDEST, recording_of
from drivegen.recording.roads import log_roads, log_signals, surroundings, times
from drivegen.store.collisions import Where

_LEGEND = """**Orange**: the target as the driver drove it; its run ends at the impact. **Orange frame**: as it was planned.
{met} **Blue**: the others. **Ball**: where and when they met.

{words}"""
_VEHICLE, _PERSON = "**Red**: the vehicle that it met.", "**Green**: people and cyclists, one of whom it met."


def record_collision(
    path: Path, scenario: Scenario, planned: Samples, driven: Trajectories, where: Where, title: str, words: str
) -> None:
    """Write the run that `where` names: `planned` are its samples, `driven` (K, T) the targets as they were driven."""
    traffic_planned = planned.motion[where.sample]
    motion = Trajectories.joined([driven[where.sample : where.sample + 1], traffic_planned[TARGET + 1 :]])
    target_planned = traffic_planned[TARGET : TARGET + 1]
    roads, signals = surroundings(scenario, [motion])
    show = layout(*window(motion, NARROWEST, WIDEST), image=False, verdicts=False)
    with recording_of(path, f"{title}: {scenario.scenario_id}", show) as recording:
        log_roads(recording, roads)
        log_signals(recording, roads, signals)
        _log_vehicles(recording, scenario, motion, where.partner)
        traffic.log_ghosts(recording, "world/planned", scenario.vehicles[TARGET : TARGET + 1], target_planned, colours.TARGET)
        traffic.log_context(recording, scenario.context)
        whole_plan = Trajectories.joined([target_planned, traffic_planned[TARGET + 1 :]])
        traffic.log_speeds(recording, scenario, {"driven": motion, "planned": whole_plan})
        _log_impact(recording, Trajectories.joined([motion, scenario.context.motion]), where.partner, where.step)
        met = _VEHICLE if where.partner < len(scenario.vehicles) else _PERSON
        recording.log("legend", rr.TextDocument(_LEGEND.format(met=met, words=words), media_type="text/markdown"), static=True)


def _log_vehicles(recording: rr.RecordingStream, scenario: Scenario, motion: Trajectories, partner: int) -> None:
    count = len(scenario.vehicles)
    shades = np.array([colours.SOCIAL] * count, np.uint8)
    shades[TARGET] = colours.TARGET
    shades[partner : partner + 1] = colours.ILLEGAL  # a person is none of the vehicles
    steady = np.broadcast_to(shades[:, None], (count, motion.steps, 4))
    traffic.log_boxes(recording, "world/traffic", motion, scenario.vehicles.size, steady, scenario.vehicles.track_id)


def _log_impact(recording: rr.RecordingStream, motion: Trajectories, partner: int, step: int) -> None:
    place = motion.position[[TARGET, partner], step].mean(0, keepdims=True)
    recording.log("world/impact", rr.Points3D.from_fields(colors=[colours.CHOSEN], radii=0.8, show_labels=True), static=True)
    ball = rr.Points3D.columns(positions=flat(place, 2.5), labels=[f"impact, {step * DT:.1f} s"])
    recording.send_columns("world/impact", indexes=times(np.array([step])), columns=ball)
