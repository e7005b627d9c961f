"""From a recording to a scenario: choose the target and the social vehicles, settle sizes, cut time and map.

Paper, problem formulation: the first frame of a log gives P, the rest T. The target is the focal track or the AV; the
social vehicles are the ones nearest to it at the first frame. Who is chosen, how large assumed boxes are and where the map is
cut are decided by the first frame alone, so that no choice tells what happens next. Every decision that changes what was
recorded is noted in the scenario and counted by the caller; a recording that yields no scenario is rejected with a countable
reason, which may lie in its future: that is a choice of recordings.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.crop import Cropper, reach
from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import boxes_overlap, wrap_angle
from drivegen.core.recorded_log import NO_TRACK, RecordedLog
from drivegen.core.scenario import DT, SAFE_ID, Actors, Scenario, Trajectories, Vehicles
from drivegen.core.settings import Count, Index, Positive, Share
from drivegen.core.signals import Signals
from drivegen.ingest.vehicles import PLANNED_KINDS, boxes_of, choose

FASTEST = 70.0
"""A road vehicle whose recorded positions or velocities ask for more [m/s] is a tracking error."""

SHORTEST_HORIZON = 10
"""A recording that goes on for fewer steps after the first frame is rejected: one second is no traffic."""


@dataclass(frozen=True)
class Settings:
    """How recordings become scenarios.

    Attributes:
        target: "focal" or "ego", whom to take as target; the other one stands in where it is absent.
        max_vehicles: target and social vehicles together.
        first_step: step of the recording that becomes step 0.
        horizon: steps after it; less where the recording ends before.
        map_radius: lanes farther [m] from where every chosen vehicle would be at its speed are left out (`crop.reach`); None
            keeps the whole map.
        smallest_shrink: assumed boxes of overlapping vehicles that stand are scaled down to this at most.
    """

    target: str
    max_vehicles: Count
    first_step: Index
    horizon: Count
    map_radius: Positive | None
    smallest_shrink: Share


def select(log: RecordedLog, settings: Settings) -> Scenario:
    """The scenario of one recording, in a frame whose origin is the target's first position, rounded to metres.

    Raises UnusableInput with reason `bad-id`, `too-short`, `no-vehicles`, `no-target`, `implausible-target`, `nothing-to-score`,
    `no-lanes` or what `Scenario.validate` finds.
    """
    _expect_safe_id(log)
    log = _cut_time(log, settings)
    notes: dict[str, str] = {}
    target = _target(log, settings.target, notes)
    log = _without_jumps(log, target, notes)
    size, source = boxes_of(log)
    chosen = choose(log, target, size, source, settings.max_vehicles, settings.smallest_shrink, notes)
    if not log.motion.valid[chosen, 1:].any():
        said = f"scenario {log.scenario_id}: none of its vehicles is seen after the first step"
        raise UnusableInput(said, reason="nothing-to-score")
    scenario = _scenario(_in_frame_of(log, chosen, settings.map_radius), chosen, size, source, notes)
    if touching := _context_overlaps(scenario):
        notes["context_overlaps"] = str(touching)
    scenario.validate()
    return scenario


def everybody(log: RecordedLog, first: int) -> Scenario:
    """All that a recording shows from step `first` on, to be looked at and not to be driven in, in a frame as `select` has it.

    Every vehicle that is ever there is in it as it was recorded, on the whole map; who is not there at step 0 has zeros there.
    The target is the focal track, else the AV, else any vehicle, which is noted. Raises UnusableInput with reason `bad-id`,
    `no-vehicles` or what `Scenario.validate` finds.
    """
    _expect_safe_id(log)
    log = _between(log, first, log.motion.steps)
    vehicles = np.flatnonzero(np.isin(log.kind, PLANNED_KINDS) & log.motion.valid.any(-1))
    if not len(vehicles):
        raise UnusableInput(f"scenario {log.scenario_id} has no vehicles", reason="no-vehicles")
    target = next((track for track in (log.focal, log.ego) if track in vehicles), vehicles[0])
    notes = {} if target == log.focal else {"target": f"{log.track_id[target]}, because no vehicle is the focal track"}
    chosen = np.append(target, vehicles[vehicles != target])
    scenario = _scenario(_in_frame_of(log, chosen, None), chosen, *boxes_of(log), notes)
    scenario.validate()
    return scenario


def _scenario(
    log: RecordedLog, chosen: NDArray[np.intp], size: NDArray[np.float32], source: NDArray[np.uint8], notes: dict[str, str]
) -> Scenario:
    motion = _tidy(log.motion[chosen])
    return Scenario(
        scenario_id=log.scenario_id,
        source=log.source,
        city=log.city,
        map=log.map,
        vehicles=Vehicles(
            track_id=log.track_id[chosen],
            kind=log.kind[chosen],
            size=size[chosen],
            size_source=source[chosen],
            position=motion.position[:, 0].copy(),
            heading=motion.heading[:, 0].copy(),
            speed=motion.speed[:, 0].copy(),
        ),
        horizon=log.motion.steps - 1,
        log=motion,
        context=_context(log, size),
        signals=log.signals,
        notes=notes,
        per_hour=log.per_hour,
    )


def _expect_safe_id(log: RecordedLog) -> None:
    if not SAFE_ID.fullmatch(log.scenario_id):
        said = f"{log.source}: {log.scenario_id[:50]!r} cannot be a scenario's id, for ids name files"
        raise UnusableInput(f"{said}: use letters, digits, dots, dashes and underscores", reason="bad-id")


def _cut_time(log: RecordedLog, settings: Settings) -> RecordedLog:
    first, last = settings.first_step, min(settings.first_step + settings.horizon + 1, log.motion.steps)
    if last - first <= SHORTEST_HORIZON:
        raise UnusableInput(
            f"scenario {log.scenario_id} has {log.motion.steps} steps: too few after step {first}", reason="too-short"
        )
    return _between(log, first, last)


def _between(log: RecordedLog, first: int, last: int) -> RecordedLog:
    """Steps `first` to `last`, the latter not included."""
    signals = Signals(log.signals.lane, log.signals.state[:, first:last])
    return replace(log, motion=log.motion.between(first, last), signals=signals)


def _target(log: RecordedLog, role: str, notes: dict[str, str]) -> int:
    """The focal track or the ego, if it is a vehicle and there at step 0; else the other one, noted."""
    if role not in ("focal", "ego"):
        raise UnusableInput(f"the target must be 'focal' or 'ego', not {role!r}")
    if not np.isin(log.kind, PLANNED_KINDS).any():
        raise UnusableInput(f"scenario {log.scenario_id} has no vehicles", reason="no-vehicles")
    names = {"focal": ("focal track", log.focal), "ego": ("AV", log.ego)}
    (word, first), (other_word, second) = names[role], names["ego" if role == "focal" else "focal"]
    problem = _unfit(log, first)
    if not problem:
        return first
    if _unfit(log, second):
        raise UnusableInput(
            f"scenario {log.scenario_id}: {word} {problem}, {other_word} {_unfit(log, second)}", reason="no-target"
        )
    notes["target"] = f"{other_word}, because the {word} {problem}"
    return second


def _unfit(log: RecordedLog, track: int) -> str:
    """Why a track cannot be the target; empty if it can."""
    if track == NO_TRACK:
        return "is not in the recording"
    if log.kind[track] not in PLANNED_KINDS:
        return "is no vehicle"
    return "" if log.motion.valid[track, 0] else "is absent at the first step"


def _without_jumps(log: RecordedLog, target: int, notes: dict[str, str]) -> RecordedLog:
    """The recording, each track ended where it first moves faster than any road vehicle: a tracking error.

    Whoever is left out so was already at the first frame. Raises UnusableInput where it is the target, ever.
    """
    wrong = _implausible(log.motion)
    if wrong[target].any():
        raise UnusableInput(f"scenario {log.scenario_id}: the target jumps about", reason="implausible-target")
    planned = wrong[np.isin(log.kind, PLANNED_KINDS) & log.motion.valid[:, 0]]
    for name, tracks in (("dropped_implausible", planned[:, 0]), ("ended_implausible", planned.any(-1) & ~planned[:, 0])):
        if tracks.any():
            notes[name] = str(np.count_nonzero(tracks))
    valid = log.motion.valid & ~np.logical_or.accumulate(wrong, axis=-1)
    return replace(log, motion=replace(log.motion, valid=valid))


def _implausible(motion: Trajectories) -> NDArray[np.bool_]:
    """(M, T) steps at which a track is faster than any road vehicle, by its velocity or by how it got there."""
    wrong = (motion.speed > FASTEST) & motion.valid
    step = np.hypot(*np.moveaxis(np.diff(motion.position, axis=1), -1, 0))
    wrong[:, 1:] |= (step > FASTEST * DT) & motion.valid[:, 1:] & motion.valid[:, :-1]
    return np.asarray(wrong)


def _in_frame_of(log: RecordedLog, chosen: NDArray[np.intp], radius: float | None) -> RecordedLog:
    """The recording in a frame near the target, the first `chosen`, its map cut to what these can reach and `radius` more."""
    old = log.map.origin
    start = log.motion.valid[chosen[0]].argmax()
    origin = np.round(log.motion.position[chosen[0], start].astype(np.float64) + old)
    shift = old - origin
    position = (log.motion.position.astype(np.float64) + shift).astype(np.float32)
    position[~log.motion.valid] = 0
    motion = replace(log.motion, position=position)
    road_map = log.map.moved_to(origin)
    if radius is None:
        return replace(log, map=road_map, motion=motion)
    within = reach(motion.speed[chosen, 0], (motion.steps - 1) * DT, radius)
    road_map, lanes = Cropper(road_map).around(position[chosen, 0], within)
    if not len(lanes):
        raise UnusableInput(f"scenario {log.scenario_id}: no lane within {radius:g} m of its vehicles' reach", reason="no-lanes")
    return replace(log, map=road_map, motion=motion, signals=log.signals.on_lanes(lanes))


def _tidy(motion: Trajectories) -> Trajectories:
    """Headings in [-pi, pi); zeros wherever nothing was recorded, so that equal scenarios have equal bytes."""
    valid = motion.valid
    return Trajectories(
        np.where(valid[..., None], motion.position, 0).astype(np.float32),
        np.where(valid, wrap_angle(motion.heading), 0).astype(np.float32),
        np.where(valid[..., None], motion.velocity, 0).astype(np.float32),
        valid,
    )


def _context(log: RecordedLog, size: NDArray[np.float32]) -> Actors:
    rows = np.flatnonzero(~np.isin(log.kind, PLANNED_KINDS) & log.motion.valid.any(-1))
    return Actors(log.track_id[rows], log.kind[rows], size[rows], _tidy(log.motion[rows]))


def _context_overlaps(scenario: Scenario) -> int:
    """Vehicle and context actor pairs that overlap at step 0 already: inherited, left as they are."""
    vehicles, actors = scenario.vehicles, scenario.context
    overlap = boxes_overlap(
        vehicles.position[:, None],
        vehicles.heading[:, None],
        vehicles.size[:, None, :2],
        actors.motion.position[None, :, 0],
        actors.motion.heading[None, :, 0],
        actors.size[None, :, :2],
    )
    return int(np.count_nonzero(overlap & actors.motion.valid[None, :, 0]))
