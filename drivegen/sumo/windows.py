"""Cut scenario windows out of simulated traffic: 11 s around a focal vehicle that drives, with the map within reach.

Which windows make scenarios depends on what happens in them (the focal vehicle drives, most others move, nobody is thrown
about). In a window that makes one, who stands for the recording vehicle and where the map ends are decided by the first frame.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.crop import Cropper, reach
from drivegen.core.geometry import boxes_overlap, wrap_angle
from drivegen.core.scenario import DT, Actors, Scenario, SizeSource, Trajectories, VehicleKind, Vehicles
from drivegen.core.settings import Count, NotNegative, Positive, Share
from drivegen.core.signals import Signals
from drivegen.sumo.network import Network
from drivegen.sumo.traffic import Traffic

SOURCE = "SUMO corpus (simulated)"

EGO = "AV"
"""Track id of the vehicle that stands for the recording one, as in Argoverse 2: the focal one's nearest at the first step."""

MOVED = 2.0
"""A vehicle moves if it gets farther than this from where it was first seen [m]."""

HARDEST = 8.0
"""More than tyres give on most roads [m/s2]: a vehicle that accelerates so in any direction was moved, not driven."""

_FOCAL_KINDS = (VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS)
_RIDDEN = (VehicleKind.MOTORCYCLE, VehicleKind.CYCLIST)


@dataclass(frozen=True)
class WindowSettings:
    """Which windows make scenarios.

    Attributes:
        steps: length T of a window.
        radius: vehicles are seen while within this distance of the focal one [m].
        map_radius: lanes are kept this far [m] around where everybody seen at the first step would be at its speed
            (`crop.reach`).
        apart: focal vehicles of windows at the same time are at least this far from each other at the first step [m].
        focal_travel: the focal vehicle gets at least this far [m].
        fewest: vehicles at the first step, the focal one included.
        moving_share: at least this share of the vehicles moves.
    """

    steps: Count
    radius: Positive
    map_radius: Positive
    apart: NotNegative
    focal_travel: NotNegative
    fewest: Count
    moving_share: Share


@dataclass(frozen=True)
class Recording:
    """Traffic on a network, with what is needed over and over to cut windows out of it."""

    network: Network
    traffic: Traffic
    cropper: Cropper
    city: str


def cut_windows(
    recording: Recording, name: str, settings: WindowSettings, random: np.random.Generator
) -> Iterator[tuple[int, Scenario]]:
    """The scenarios of a recording in order of time, called `<name>-<first step>-<track id>`, each when asked for.

    With the number of each one's window in time. It stands for all vehicles of that window that could be focal ones, shared
    among those that were tried: `per_hour` is how often such scenarios would occur in an hour like that window.
    """
    motion = recording.traffic.motion
    for first in range(0, motion.steps - settings.steps + 1, settings.steps):
        window = motion.between(first, first + settings.steps)
        clashes = overlapping_pairs(window, recording.traffic.size)
        broken = thrown(window)
        fit, chosen = _focal_vehicles(window, recording.traffic.kind, settings, random)
        per_hour = 3600.0 / (settings.steps * DT) * fit / max(len(chosen), 1)
        for focal in chosen:
            visible = _seen(window, focal, clashes, broken, settings)
            if visible is not None:
                scenario_id = f"{name}-{first:05d}-{recording.traffic.track_id[focal]}"
                scenario = _scenario(recording, window, (first, focal), visible, settings, scenario_id)
                yield first // settings.steps, replace(scenario, per_hour=per_hour)


def _focal_vehicles(
    window: Trajectories, kind: NDArray[np.uint8], settings: WindowSettings, random: np.random.Generator
) -> tuple[int, list[int]]:
    """How many vehicles are there throughout and drive, and those far enough apart that are taken, in random order."""
    travel = np.hypot(*(window.position[:, -1] - window.position[:, 0]).T)
    fit = window.valid.all(-1) & (travel >= settings.focal_travel) & np.isin(kind, _FOCAL_KINDS)
    chosen: list[int] = []
    begin = window.position[:, 0]
    for vehicle in random.permutation(np.flatnonzero(fit)).tolist():
        gaps = np.hypot(*(begin[chosen] - begin[vehicle]).T)
        if (gaps >= settings.apart).all():
            chosen.append(vehicle)
    return int(np.count_nonzero(fit)), chosen


def _seen(
    window: Trajectories, focal: int, clashes: NDArray[np.intp], broken: NDArray[np.bool_], settings: WindowSettings
) -> NDArray[np.bool_] | None:
    """Where each vehicle is seen (V, T), or None where the window makes no scenario.

    SUMO keeps gaps along lanes, not between boxes, so waiting and turning vehicles sometimes overlap in junctions, and
    where drawn lanes do not meet vehicles jump: windows that show such a pair or such a vehicle are left out.
    """
    gap = window.position - window.position[focal]
    visible: NDArray[np.bool_] = window.valid & ((gap**2).sum(-1) <= settings.radius**2)
    if np.count_nonzero(visible[:, 0]) < settings.fewest:
        return None
    shown = np.asarray(visible.any(-1))
    if shown[clashes].all(-1).any() or (shown & broken).any():
        return None
    moving = moves(replace(window[shown], valid=visible[shown]))
    return visible if moving.mean() >= settings.moving_share else None


def moves(motion: Trajectories) -> NDArray[np.bool_]:
    """(...) whether each track gets farther than MOVED from where it was first seen."""
    first = np.argmax(motion.valid, axis=-1)[..., None, None]
    gap = motion.position - np.take_along_axis(motion.position, first, axis=-2)
    return np.asarray((motion.valid & (np.hypot(gap[..., 0], gap[..., 1]) > MOVED)).any(-1))


def thrown(motion: Trajectories) -> NDArray[np.bool_]:
    """(...) whether a track accelerates by more than HARDEST, by its velocities or by how fast its heading turns."""
    both = motion.valid[..., 1:] & motion.valid[..., :-1]
    change = np.linalg.norm(np.diff(motion.velocity, axis=-2), axis=-1)
    turn = np.abs(wrap_angle(np.diff(motion.heading, axis=-1))) * motion.speed[..., 1:]
    return np.asarray((both & (np.maximum(change, turn) > HARDEST * DT)).any(-1))


def _visible_motion(
    window: Trajectories, rows: NDArray[np.intp], visible: NDArray[np.bool_], shift: NDArray[np.float32]
) -> Trajectories:
    """The tracks `rows` (R,), moved by `shift` [m], where they are visible (R, T); zeros elsewhere."""
    return Trajectories(
        np.where(visible[..., None], window.position[rows] + shift, 0.0),
        np.where(visible, window.heading[rows], 0.0).astype(np.float32),
        np.where(visible[..., None], window.velocity[rows], 0.0).astype(np.float32),
        visible,
    )


def _vehicles(traffic: Traffic, rows: NDArray[np.intp], motion: Trajectories) -> Vehicles:
    """The tracks `rows` (R,) as they are first visible; the nearest motor vehicle behind the focal one in order is the ego."""
    names, kind = traffic.track_id[rows].astype(object), traffic.kind[rows]
    names[np.flatnonzero(motion.valid[:, 0] & np.isin(kind, _FOCAL_KINDS))[1:2]] = EGO
    first = np.arange(len(rows)), np.argmax(motion.valid, axis=-1)
    return Vehicles(
        track_id=names.astype(np.str_),
        kind=kind,
        size=traffic.size[rows],
        size_source=np.full(len(rows), SizeSource.MEASURED, np.uint8),
        position=motion.position[first],
        heading=motion.heading[first],
        speed=motion.speed[first],
    )


def _scenario(
    recording: Recording,
    window: Trajectories,
    at: tuple[int, int],
    visible: NDArray[np.bool_],
    settings: WindowSettings,
    scenario_id: str,
) -> Scenario:
    first, focal = at
    traffic = recording.traffic
    rows = np.flatnonzero(visible.any(-1))
    gap = np.hypot(*(window.position[rows, 0] - window.position[focal, 0]).T)
    rows = rows[np.lexsort((rows, np.where(visible[rows, 0], gap, np.inf)))]  # the focal one first, then by distance
    origin = np.round(window.position[focal, 0].astype(np.float64) + recording.network.map.origin)
    here = rows[visible[rows, 0]]
    within = reach(window.speed[here, 0], (settings.steps - 1) * DT, settings.map_radius)
    cut, lanes = recording.cropper.around(window.position[here, 0], within)
    motion = _visible_motion(window, rows, visible[rows], (recording.network.map.origin - origin).astype(np.float32))
    vehicles = _vehicles(traffic, rows, motion)
    ridden = np.isin(vehicles.kind, _RIDDEN)
    riders = Actors(vehicles.track_id[ridden], vehicles.kind[ridden], vehicles.size[ridden], motion[ridden])
    return Scenario(
        scenario_id=scenario_id,
        source=SOURCE,
        city=recording.city,
        map=cut.moved_to(origin),
        vehicles=vehicles[~ridden],
        horizon=settings.steps - 1,
        log=motion[~ridden],
        context=riders,
        signals=_signals(recording, first, settings.steps).on_lanes(lanes),
    )


def _signals(recording: Recording, first: int, steps: int) -> Signals:
    """What the lights showed on the whole network; UNKNOWN for links that SUMO does not switch."""
    network = recording.network
    state = np.zeros((len(network.signal_lane), steps), np.uint8)
    for name, shown in recording.traffic.lights.items():
        rows = np.flatnonzero(network.signal_name == name)
        rows = rows[network.signal_link[rows] < len(shown)]
        state[rows] = shown[network.signal_link[rows], first : first + steps]
    return Signals(network.signal_lane, state)


def overlapping_pairs(motion: Trajectories, size: NDArray[np.float32]) -> NDArray[np.intp]:
    """Pairs (P, 2) of tracks (V, T) whose boxes `size` (V, 3) overlap at any step while both are valid."""
    half = np.hypot(size[:, 0], size[:, 1])[:, None] / 2
    low = np.where(motion.valid[..., None], motion.position, np.inf).min(1) - half
    high = np.where(motion.valid[..., None], motion.position, -np.inf).max(1) + half
    a, b = np.nonzero(np.triu(((low[:, None] <= high) & (low <= high[:, None])).all(-1), 1))  # their paths come near
    pair, step = np.nonzero(motion.valid[a] & motion.valid[b])
    boxes = [(motion.position[i, step], motion.heading[i, step], size[i, :2]) for i in (a[pair], b[pair])]
    close = ((boxes[0][0] - boxes[1][0]) ** 2).sum(-1) <= (half[a[pair], 0] + half[b[pair], 0]) ** 2
    pair, boxes = pair[close], [(p[close], h[close], s[close]) for p, h, s in boxes]
    hit = np.unique(pair[boxes_overlap(*boxes[0], *boxes[1])])
    return np.stack([a[hit], b[hit]], axis=-1)
