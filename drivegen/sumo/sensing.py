"""What a recording vehicle would have measured: tracks with noise, and only while somebody can be seen."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d

from drivegen.core.geometry import box_corners, rotate
from drivegen.core.scenario import DT, Actors, Scenario, Trajectories
from drivegen.core.settings import NotNegative, Positive, Share


@dataclass(frozen=True)
class SensingSettings:
    """How the simulated truth is measured.

    Attributes:
        share: of the recordings that are measured so; the others are the truth.
        occlusion: tracks have gaps where another vehicle hides them from the recording one (from the focal one where
            there is no recording one).
        position_noise: standard deviation of each coordinate [m]. heading_noise: of the heading [rad].
        noise_time: over which errors last [s]: trackers are off for a while, not anew at each step.
    """

    share: Share
    occlusion: bool
    position_noise: NotNegative
    heading_noise: NotNegative
    noise_time: Positive


def sensed(scenario: Scenario, observer: str, settings: SensingSettings, random: np.random.Generator) -> Scenario:
    """The scenario as measured from the vehicle with track id `observer`; nobody hides that vehicle or the focal one.

    Velocities are off by what the error of the position changes. Initial states follow their tracks.
    """
    if scenario.log is None:
        return scenario
    count = len(scenario.vehicles)
    motion = Trajectories.joined([scenario.log, scenario.context.motion])
    if settings.occlusion:
        names = scenario.vehicles.track_id.tolist()
        eye = names.index(observer) if observer in names else 0
        size = np.concatenate([scenario.vehicles.size, scenario.context.size])
        hidden = _hidden(motion, size, eye)
        hidden[[0, eye]] = False
        motion = replace(motion, valid=motion.valid & ~hidden)
    motion = _noisy(motion, settings, random)
    log, riders = motion[:count], motion[count:]
    present, met = log.valid.any(-1), riders.valid.any(-1)
    log, riders = log[present], riders[met]
    context = Actors(scenario.context.track_id[met], scenario.context.kind[met], scenario.context.size[met], riders)
    start, each = np.argmax(log.valid, axis=-1), np.arange(len(log.valid))
    vehicles = replace(
        scenario.vehicles[present],
        position=log.position[each, start],
        heading=log.heading[each, start],
        speed=log.speed[each, start],
    )
    return replace(scenario, vehicles=vehicles, log=log, context=context)


def _noisy(motion: Trajectories, settings: SensingSettings, random: np.random.Generator) -> Trajectories:
    off = settings.position_noise * _lasting((*motion.valid.shape, 2), settings.noise_time, random)
    turned = settings.heading_noise * _lasting((*motion.valid.shape, 1), settings.noise_time, random)[..., 0]
    return replace(
        motion,
        position=(motion.position + off).astype(np.float32),
        heading=(motion.heading + turned).astype(np.float32),
        velocity=(motion.velocity + np.gradient(off, DT, axis=1)).astype(np.float32),
    )


def _lasting(shape: tuple[int, ...], seconds: float, random: np.random.Generator) -> NDArray[np.float64]:
    """Gaussian noise (N, T, C) of variance 1 whose autocorrelation over time falls as a Gaussian of `seconds`."""
    width = seconds / DT / np.sqrt(2)
    reach = int(np.ceil(4 * width))
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    white = random.standard_normal((shape[0], shape[1] + 2 * reach, shape[2]))
    return np.asarray(convolve1d(white, weight / np.linalg.norm(weight), axis=1)[:, reach:-reach])


def _hidden(motion: Trajectories, size: NDArray[np.float32], eye: int) -> NDArray[np.bool_]:
    """(N, T) whether every line of sight from vehicle `eye` to a vehicle's centre and corners meets another box."""
    points = np.concatenate(
        [motion.position[:, :, None], box_corners(motion.position, motion.heading, size[:, :1], size[:, 1:2])], axis=2
    )
    there = motion.valid[eye][:, None]
    from_eye = np.where(there, motion.position[eye], motion.position[0])  # (T, 2); once it is gone, from the focal vehicle
    hidden = np.ones(points.shape[:3], np.bool_)
    for target in range(len(size)):
        blocked = np.zeros(points.shape[1:3], np.bool_)
        for other in range(len(size)):
            if other not in (target, eye):
                crossed = _crosses(from_eye, points[target], motion[other], size[other])
                blocked |= crossed & motion.valid[other][:, None]
        hidden[target] = blocked
    return np.asarray(hidden.all(-1))


def _crosses(
    start: NDArray[np.float32], end: NDArray[np.float32], box: Trajectories, size: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """(T, P) whether the segments from `start` (T, 2) to `end` (T, P, 2) meet the moving box (slab test in its frame)."""
    a = rotate(start - box.position, -box.heading)[:, None]
    step = rotate(end - box.position[:, None], -box.heading[:, None]) - a
    step = np.where(np.abs(step) < 1e-9, 1e-9, step)
    low, high = (-size[:2] / 2 - a) / step, (size[:2] / 2 - a) / step
    enter = np.maximum(np.minimum(low, high).max(-1), 0.0)
    leave = np.minimum(np.maximum(low, high).min(-1), 1.0)
    return np.asarray(enter < leave)
