"""Moving boxes in a recording, and what is plotted of them: speed, and clearance around the target."""

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from drivegen.core.geometry import boxes_gap
from drivegen.core.rejections import Rejected
from drivegen.core.samples import Samples, Violation
from drivegen.core.scenario import DT, TARGET, Actors, Scenario, Trajectories, Vehicles
from drivegen.recording import colours
from drivegen.recording.lines import flat, thinned
from drivegen.recording.roads import times

FREE = 50.0
"""A clearance beyond this is drawn as this [m]."""


def log_vehicles(
    recording: rr.RecordingStream, scenario: Scenario, motion: Trajectories, samples: Samples | None, sample: int
) -> None:
    """The target and the social vehicles below `world/traffic`, and their paths; red from the first violation on."""
    count = len(scenario.vehicles)
    first = np.full(count, -1) if samples is None else samples.first_violation[sample].astype(np.int64)
    base = np.array([colours.TARGET] + [colours.SOCIAL] * (count - 1), np.uint8)
    illegal = (first >= 0)[:, None] & (np.arange(motion.steps) >= first[:, None])
    shades = np.where(illegal[..., None], np.array(colours.ILLEGAL, np.uint8), base[:, None])
    ids = scenario.vehicles.track_id
    for path, rows in (("target", slice(0, 1)), ("social", slice(1, None))):
        log_boxes(recording, f"world/traffic/{path}", motion[rows], scenario.vehicles.size[rows], shades[rows], ids[rows])
    lines = [(i, line) for i in range(count) for line in motion[i].stretches() if len(line) > 1]
    shown = [(*(colours.ILLEGAL if first[i] >= 0 else base[i].tolist())[:3], 110) for i, _ in lines]
    paths = rr.LineStrips3D([flat(thinned(line), 0.05) for _, line in lines], colors=shown, radii=0.12)
    recording.log("world/paths", paths, static=True)


def log_ghosts(
    recording: rr.RecordingStream, path: str, vehicles: Vehicles, motion: Trajectories, colour: colours.Colour = colours.LOGGED
) -> None:
    """Vehicles as wire frames that move otherwise than those that are shown: as they were logged, or planned."""
    shades = np.broadcast_to(np.array(colour, np.uint8), (*motion.valid.shape, 4))
    log_boxes(recording, path, motion, vehicles.size, shades, vehicles.track_id, rr.components.FillMode.MajorWireframe)


def log_context(recording: rr.RecordingStream, context: Actors) -> None:
    """Pedestrians and cyclists."""
    shades = np.broadcast_to(np.array(colours.CONTEXT, np.uint8), (*context.motion.valid.shape, 4))
    log_boxes(recording, "world/context", context.motion, context.size, shades, context.track_id)


def log_boxes(
    recording: rr.RecordingStream,
    path: str,
    motion: Trajectories,
    size: NDArray[np.float32],
    shades: NDArray[np.uint8],
    labels: NDArray[np.str_],
    fill: rr.components.FillMode = rr.components.FillMode.Solid,
) -> None:
    """Boxes (N, T) of sizes (N, 3) and colours (N, T, 4) at `path`; each step holds those that are valid then.

    Places and headings are written at every step, what else a box has only where it changes: the viewer keeps what it was
    told last, and half of a recording would be repetition.
    """
    if len(labels) == 0:
        return
    recording.log(path, rr.Boxes3D.from_fields(fill_mode=fill, radii=0.05, show_labels=False), static=True)
    step, row = np.nonzero(motion.valid.T)
    half = motion.heading[row, step] / 2
    zero = np.zeros_like(half)
    columns = rr.Boxes3D.columns(
        centers=np.concatenate([motion.position[row, step], size[row, 2:] / 2], axis=1),
        quaternions=np.stack([zero, zero, np.sin(half), np.cos(half)], axis=1),
    )
    counts = np.bincount(step, minlength=motion.steps)
    recording.send_columns(path, indexes=times(np.arange(motion.steps)), columns=columns.partition(counts))
    shown = np.concatenate([motion.valid[..., None], shades], axis=-1)
    changes = np.concatenate([[0], 1 + np.flatnonzero((shown[:, 1:] != shown[:, :-1]).any(axis=(0, 2)))])
    step, row = np.nonzero(motion.valid.T[changes])
    columns = rr.Boxes3D.columns(half_sizes=size[row] / 2, colors=shades[row, changes[step]], labels=labels[row].tolist())
    recording.send_columns(path, indexes=times(changes), columns=columns.partition(np.bincount(step, minlength=len(changes))))


def log_speeds(recording: rr.RecordingStream, scenario: Scenario, motions: dict[str, Trajectories]) -> None:
    """The target's speed and its clearance, one series a motion by its name, the one that is shown first, below `plots`."""
    for (name, motion), shade in zip(motions.items(), (colours.TARGET, colours.PLOTTED), strict=False):
        steps = np.flatnonzero(motion.valid[TARGET])
        series = {"speed": motion.speed[TARGET], "clearance": clearance(scenario, motion)}
        for kind, values in series.items():
            path = f"plots/{kind}/{name}"
            recording.log(path, rr.SeriesLines(colors=[shade], names=[f"{name} {kind}"], widths=[2.0]), static=True)
            recording.send_columns(path, indexes=times(steps), columns=rr.Scalars.columns(scalars=values[steps]))


def clearance(scenario: Scenario, motion: Trajectories) -> NDArray[np.float32]:
    """(T,) [m] from the target's box to the nearest vehicle or actor, at most FREE; 0 where they overlap."""
    position = np.concatenate([motion.position[1:], scenario.context.motion.position])
    heading = np.concatenate([motion.heading[1:], scenario.context.motion.heading])
    valid = np.concatenate([motion.valid[1:], scenario.context.motion.valid])
    size = np.concatenate([scenario.vehicles.size[1:], scenario.context.size])[:, None, :2]
    own = scenario.vehicles.size[TARGET, :2]
    gap = boxes_gap(motion.position[TARGET], motion.heading[TARGET], own, position, heading, size)
    nearest: NDArray[np.float32] = np.where(valid, gap, FREE).min(axis=0, initial=FREE).astype(np.float32)
    return nearest


def log_verdicts(
    recording: rr.RecordingStream, scenario: Scenario, samples: Samples, sample: int, rejected: Rejected | None = None
) -> None:
    """One line a vehicle: legal, or what was violated and when; illegal ones at the step of their violation.

    `rejected` are those of this sample; a line then says how many of its vehicle's trajectories were turned down, and why.
    """
    lines = []
    for i, track in enumerate(scenario.vehicles.track_id):
        flags, first = Violation(int(samples.violation[sample, i])), int(samples.first_violation[sample, i])
        who = "target" if i == TARGET else f"vehicle {track}"
        left = (int(samples.motion[sample, i].last_valid()) + 1) * DT
        gone = f", leaves the map after {left:.1f} s" if samples.left_map[sample, i] else ""
        tries = f"{gone}, {int(samples.attempts[sample, i])} planned" if samples.attempts[sample, i] > 1 else gone
        if rejected is not None and (own := rejected.only(rejected.vehicle == i)):
            tries += f", {own.summary}"
        if samples.dropped[sample, i]:
            lines.append((0, f"{who}: left out, nothing legal was found{tries}", "WARN"))
        elif flags is Violation.NONE:
            lines.append((0, f"{who}: legal{tries}", "INFO"))
        else:
            what = ", ".join(str(kind.name).lower().replace("_", " ") for kind in flags)
            lines.append((max(first, 0), f"{who}: {what} from step {first}{tries}", "ERROR"))
    lines.sort(key=lambda line: line[0])
    steps, text, level = zip(*lines, strict=True)
    recording.send_columns("verdicts", indexes=times(np.array(steps)), columns=rr.TextLog.columns(text=text, level=level))
