"""One scenario as a Rerun recording (.rrd) with its layout saved inside: `rerun FILE` shows it.

Entities (x, y, z in the map's frame, metres; time lines "time" [s] and "step"):

    world/roads/*          surface, boundaries, connections, drivable, crossings, stop_lines
    world/signals          bars across guarded lanes, coloured by state
    world/traffic/*        target and social vehicles: what is shown, generated or logged
    world/logged           the log as wire frames, where generated traffic is shown
    world/context          pedestrians and cyclists
    world/paths            the lines that vehicles drive
    world/rejected         dashed: what the checker turned down for this sample, and was planned again
    world/goals/*          candidates, the target's chosen one, the chosen ones of the others
    legend                 what is what
    bird_eye               the target's candidate goals, from above
    plots/speed, plots/clearance, verdicts

Identities and times inside an .rrd are drawn anew by Rerun at every write, so two recordings of one scenario have the
same content but not the same bytes.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.rejections import Rejected
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Scenario
from drivegen.core.viewport import window
from drivegen.recording import colours, traffic
from drivegen.recording.blueprint import layout
from drivegen.recording.lines import flat, log_rejected
from drivegen.recording.roads import log_roads, log_signals, surroundings
from drivegen.store.files import write_bytes

NARROWEST, WIDEST = 60.0, 260.0
"""Limits of the first view's width [m]."""


@dataclass(frozen=True)
class GoalMarks:
    """C candidate goals of a scene's vehicles, as they are drawn.

    Attributes:
        position: (C, 2) float32 [m], at the exit for a goal beyond it.
        vehicle: (C,) int32 whose goal it is.
        number: (C,) int32 its number in the bird-eye image.
        probability: (C,) float32 the selector's.
        leaves_after: (C,) float32 [s] until the vehicle leaves the map, inf where it does not.
        chosen: (C,) bool whether it was followed.
    """

    position: NDArray[np.float32]
    vehicle: NDArray[np.int32]
    number: NDArray[np.int32]
    probability: NDArray[np.float32]
    leaves_after: NDArray[np.float32]
    chosen: NDArray[np.bool_]


def record_scenario(
    path: Path,
    scenario: Scenario,
    samples: Samples | None = None,
    sample: int = 0,
    goals: GoalMarks | None = None,
    bird_eye: NDArray[np.uint8] | None = None,
    rejected: Rejected | None = None,
    log_name: str = "logged",
) -> None:
    """Write the recording of `scenario`: its log, or sample number `sample` of `samples` with the log as ghosts.

    `log_name` says what the scenario's own motion is. `bird_eye` is an (H, W, 3) RGB image; of `rejected`, what belongs to this
    sample is shown. Raises UnusableInput where there is neither a log nor a sample to show, or nobody in it.
    """
    motion = scenario.log if samples is None else samples.motion[sample]
    if motion is None:
        raise UnusableInput(f"scenario {scenario.scenario_id} has no log: give generated samples to record", reason="no-motion")
    centre, extent = window(motion, NARROWEST, WIDEST)
    show = layout(centre, extent, image=bird_eye is not None, verdicts=samples is not None)
    mine = None if rejected is None else rejected.only(rejected.sample == sample)
    roads, signals = surroundings(scenario, [motion] if scenario.log is None else [motion, scenario.log])
    with recording_of(path, f"{scenario.scenario_id} ({scenario.source})", show) as recording:
        log_roads(recording, roads)
        log_signals(recording, roads, signals)
        traffic.log_vehicles(recording, scenario, motion, samples, sample)
        traffic.log_context(recording, scenario.context)
        motions = {"generated" if samples is not None else log_name: motion}
        if samples is not None:
            traffic.log_verdicts(recording, scenario, samples, sample, mine)
            if scenario.log is not None:
                traffic.log_ghosts(recording, "world/logged", scenario.vehicles, scenario.log)
                motions[log_name] = scenario.log
        traffic.log_speeds(recording, scenario, motions)
        if mine is not None:
            log_rejected(recording, "world/rejected", mine)
        if goals is not None:
            _log_goals(recording, goals)
        recording.log(
            "legend", rr.TextDocument(_legend(list(motions), samples is not None), media_type="text/markdown"), static=True
        )
        if bird_eye is not None:
            recording.log("bird_eye", rr.Image(bird_eye).compress(jpeg_quality=75), static=True)


def _legend(motions: list[str], judged: bool) -> str:
    """What is seen, in words; `motions` are the names of the motion that is shown and, if there is one, of the ghosts."""
    shown = f"**Boxes** move as {motions[0]}: orange the target, blue the others, green people and cyclists"
    frames = f" **White frames**: {motions[1]}." if len(motions) > 1 else ""
    if not judged:
        return f"{shown}."
    return (
        f"{shown}, red from the first fault on that the checker finds.{frames} **Violet**: goals that may be chosen (small; the "
        "target's orange) and those that are followed (large). **Thin pale dashes**: planned, turned down by the checker and "
        "replaced."
    )


@contextmanager
def recording_of(path: Path, name: str, show: rrb.Blueprint) -> Iterator[rr.RecordingStream]:
    """A stream called `name` and laid out as `show`, kept in memory, written to `path` in one piece when the block ends well.

    Its identity is its own: the viewer makes one recording of all that share one, as files of the same name would.
    Rerun's own file sink is not used: its writer thread dies on a full disk, and flushing it may then wait for ever.
    """
    recording = rr.RecordingStream("drivegen", recording_id=str(uuid4()), send_properties=False)
    memory = recording.memory_recording()
    recording.send_recording_name(name)
    recording.send_blueprint(show)
    yield recording
    raw = memory.drain_as_bytes()
    recording.disconnect()
    write_bytes(path, raw)


def _log_goals(recording: rr.RecordingStream, goals: GoalMarks) -> None:
    """All candidates as small points, the target's orange; the chosen ones large, with number and probability when pointed at."""
    rest, chosen = ~goals.chosen, goals.chosen
    if rest.any():
        shades = [colours.TARGET_CANDIDATE if owner == TARGET else colours.CANDIDATE for owner in goals.vehicle[rest]]
        points = rr.Points3D(flat(goals.position[rest], 0.2), colors=shades, radii=0.35)
        recording.log("world/goals/candidates", points, static=True)
    if chosen.any():
        columns = (goals.number[chosen], goals.probability[chosen], goals.leaves_after[chosen])
        labels = np.array([f"{n}: {p:.0%}{_departure(after)}" for n, p, after in zip(*columns, strict=True)])
        mine = goals.vehicle[chosen] == TARGET
        for path, rows in (("target", mine), ("chosen", ~mine)):  # only the target's words are shown unasked: all would overlap
            points = flat(goals.position[chosen][rows], 0.2)
            shown = rr.Points3D(points, colors=[colours.CHOSEN], radii=0.9, labels=labels[rows], show_labels=path == "target")
            recording.log(f"world/goals/{path}", shown, static=True)


def _departure(after: float) -> str:
    return f", leaves the map after {after:.1f} s" if np.isfinite(after) else ""
