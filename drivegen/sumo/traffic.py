"""Simulate traffic with SUMO in a process of its own and return what drove as arrays.

libsumo records tracks with its own floating-car device, which is four times cheaper than asking for each vehicle from
Python. SUMO gives the front bumper's middle and a compass angle; here everything is a box's centre and a heading
counter-clockwise from +x.
"""

import importlib.util
import json
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from drivegen.core.errors import MissingTool
from drivegen.core.geometry import unit, wrap_angle
from drivegen.core.scenario import DT, Trajectories, VehicleKind
from drivegen.sumo import child
from drivegen.sumo.child import SimulationFailed
from drivegen.sumo.programs import decode

_PROGRAM = Path(__file__).with_name("simulation.py")

SMOOTHING = 0.3
"""Standard deviation of the time over which tracks are averaged [s]."""

_REACH = round(3 * SMOOTHING / DT)
"""Steps before and after that an average goes over."""

LAG = _REACH + 1
"""Steps by which tracks are behind: a position averages what was until now, a velocity is the slope of two of those."""


@dataclass(frozen=True)
class Run:
    """One simulation.

    Attributes:
        seed: of SUMO's own random numbers.
        warm_up: seconds before recording begins.
        seconds: recorded time [s].
        lateral_resolution: width of a sublane [m]; 0 makes vehicles keep to lane centres.
        time_limit: [s] of processor time, and half as much again of waiting, after which the run is given up.
    """

    seed: int
    warm_up: float
    seconds: float
    lateral_resolution: float
    time_limit: float


@dataclass(frozen=True)
class Traffic:
    """V vehicles over T steps of 0.1 s.

    Attributes:
        track_id: (V,) str. kind: (V,) uint8 VehicleKind. size: (V, 3) float32 length, width, height [m].
        motion: Trajectories (V, T) of box centres, relative to the given origin, as a tracker knows them at each step:
            LAG steps late, so that no state depends on what happens later.
        lights: uint8 SignalState (K, T) of the K links of each traffic light.
    """

    track_id: NDArray[np.str_]
    kind: NDArray[np.uint8]
    size: NDArray[np.float32]
    motion: Trajectories
    lights: dict[str, NDArray[np.uint8]]


def simulate(network: bytes, demand: bytes, origin: NDArray[np.float64], run: Run) -> Traffic:
    """Drive `demand` (a routes file) on `network` (a .net.xml); positions are relative to `origin` (2,) [m].

    Raises SimulationFailed whatever SUMO does, and MissingTool without libsumo.
    """
    if importlib.util.find_spec("libsumo") is None:
        raise MissingTool("libsumo is not installed: pip install libsumo==1.28.0")
    first, steps = round(run.warm_up / DT), round(run.seconds / DT)
    with tempfile.TemporaryDirectory(prefix="drivegen-sumo-") as name:
        folder = Path(name)
        (folder / "net.net.xml").write_bytes(network)
        (folder / "demand.rou.xml").write_bytes(demand)
        task = {"first": first, "steps": steps, "time_limit": run.time_limit, "arguments": _arguments(folder, run)}
        (folder / "run.json").write_text(json.dumps(task))
        child.simulate(_PROGRAM, folder, run.time_limit)
        tracks = pq.read_table(folder / "tracks.parquet")
        types = json.loads((folder / "types.json").read_text())
        changes = json.loads((folder / "lights.json").read_text())
    if not tracks.num_rows or "vehicle_id" not in tracks.column_names:  # without a vehicle there are no columns either
        raise SimulationFailed("no vehicle drove: no route of the demand fits the network", reason="no-traffic")
    lights = {light: _states(changed, first, steps) for light, changed in changes.items()}
    return _dense(tracks, types, lights, origin, (first - LAG, steps))


def _arguments(folder: Path, run: Run) -> list[str]:
    tracks = {
        "--fcd-output": str(folder / "tracks.parquet"),
        "--fcd-output.attributes": "id,x,y,angle,type",
        "--device.fcd.begin": str(max(run.warm_up - LAG * DT, 0.0)),
        "--precision": "4",
    }
    quiet = {"--no-step-log": "true", "--no-warnings": "true", "--duration-log.disable": "true"}
    rules = {
        "--step-length": str(DT),
        "--time-to-teleport": "-1",  # nobody vanishes
        "--collision.action": "none",
        "--ignore-route-errors": "true",
        "--extrapolate-departpos": "true",
        "--seed": str(run.seed % 2**31),
        "--xml-validation": "never",  # the network was parsed by us; validation would cost more than the run
        "--xml-validation.net": "never",
    }
    sublanes = {"--lateral-resolution": str(run.lateral_resolution)} if run.lateral_resolution > 0 else {}
    inputs = {"-n": str(folder / "net.net.xml"), "-r": str(folder / "demand.rou.xml")}
    return [word for pair in (inputs | tracks | quiet | rules | sublanes).items() for word in pair]


def _states(changes: list[list[object]], first: int, steps: int) -> NDArray[np.uint8]:
    """(K, T) from the steps at which a light changed and the letters that it showed from then on."""
    since = np.array([step for step, _ in changes])
    shown = decode(str(letters) for _, letters in changes)
    return np.ascontiguousarray(shown[np.searchsorted(since, np.arange(first, first + steps), side="right") - 1].T)


def _dense(
    tracks: pa.Table,
    types: dict[str, tuple[str, float, float, float]],
    lights: dict[str, NDArray[np.uint8]],
    origin: NDArray[np.float64],
    window: tuple[int, int],
) -> Traffic:
    """`window`: the step of the run that is shown first, and how many are; LAG more were recorded."""
    first, steps = window
    ids = pc.dictionary_encode(tracks["vehicle_id"].combine_chunks())
    kinds = pc.dictionary_encode(tracks["vehicle_type"].combine_chunks())
    row, column = ids.indices.to_numpy(), np.rint(tracks["timestep_time"].to_numpy() / DT).astype(np.int64) - first
    names = np.array(ids.dictionary.to_pylist(), np.str_)
    boxes = np.array([types[name][1:] for name in kinds.dictionary.to_pylist()], np.float32).reshape(-1, 3)
    shapes = np.array([_kind(types[name][0]) for name in kinds.dictionary.to_pylist()], np.uint8)
    of_vehicle = np.zeros(len(names), np.int64)
    of_vehicle[row] = kinds.indices.to_numpy()
    size = boxes[of_vehicle]
    heading = np.radians(90.0 - tracks["vehicle_angle"].to_numpy())
    front = np.stack([tracks["vehicle_x"].to_numpy(), tracks["vehicle_y"].to_numpy()], axis=-1) - origin
    motion = Trajectories.empty(len(names), steps + LAG)
    motion.position[row, column] = front - unit(heading) * (size[row, :1] / 2)
    motion.heading[row, column] = (heading + np.pi) % (2 * np.pi) - np.pi
    motion.valid[row, column] = True
    motion = tracked(motion)
    order = np.argsort(names.astype(np.int64) if np.char.isdigit(names).all() else names, kind="stable")
    order = order[motion.valid[order].any(-1)]
    return Traffic(names[order], shapes[of_vehicle][order], size[order], motion[order], lights)


def tracked(raw: Trajectories) -> Trajectories:
    """Tracks (V, T) of `raw` boxes (V, T + LAG): step t is smoothed and has the slope of what `raw` shows until t + LAG."""
    motion = smoothed(raw)
    return replace(motion, velocity=_velocity(motion)).until(raw.steps - LAG)


def smoothed(motion: Trajectories) -> Trajectories:
    """Positions and headings averaged over time by a Gaussian of SMOOTHING, as whoever tracks vehicles does.

    SUMO's vehicles turn on the spot at corners of a lane's drawn line and jump a little where one lane takes over from
    another. Near the ends of a track the average narrows and stays symmetric, so uniform motion is left as it is.
    Velocities are not touched.
    """
    position, heading, valid = motion.position, motion.heading, motion.valid
    weight = np.exp(-0.5 * (np.arange(1, _REACH + 1) * DT / SMOOTHING) ** 2)
    weight = (weight / (1 + 2 * weight.sum())).astype(np.float32)
    moved, turned = np.zeros_like(position), np.zeros_like(heading)
    for k, share in enumerate(weight.tolist(), 1):
        here, before, after = np.s_[:, k:-k], np.s_[:, : -2 * k], np.s_[:, 2 * k :]
        both = (valid[here] & valid[before] & valid[after]) * np.float32(share)
        moved[here] += both[..., None] * (position[before] + position[after] - 2 * position[here])
        turns = wrap_angle(heading[before] - heading[here]) + wrap_angle(heading[after] - heading[here])
        turned[here] += both * turns.astype(np.float32)
    return Trajectories(position + moved, wrap_angle(heading + turned).astype(np.float32), motion.velocity, valid)


def _velocity(motion: Trajectories) -> NDArray[np.float32]:
    """Central differences of positions, one-sided where a track begins or ends, 0 for a single step."""
    position, valid = motion.position.astype(np.float64), motion.valid
    after, before = np.roll(position, -1, axis=1), np.roll(position, 1, axis=1)
    has_after, has_before = np.roll(valid, -1, axis=1), np.roll(valid, 1, axis=1)
    has_after[:, -1] = has_before[:, 0] = False
    forward = np.where(has_after[..., None], after - position, 0.0)
    backward = np.where(has_before[..., None], position - before, 0.0)
    count = np.maximum(has_after.astype(int) + has_before, 1)[..., None]
    return np.where(valid[..., None], (forward + backward) / (count * DT), 0.0).astype(np.float32)


def _kind(shape: str) -> VehicleKind:
    """Kind of vehicle by SUMO's guiShape."""
    for word, kind in _KINDS.items():
        if shape.startswith(word):
            return kind
    return VehicleKind.CAR


_KINDS = {
    "truck": VehicleKind.TRUCK,
    "bus": VehicleKind.BUS,
    "coach": VehicleKind.BUS,
    "motorcycle": VehicleKind.MOTORCYCLE,
    "moped": VehicleKind.MOTORCYCLE,
    "scooter": VehicleKind.MOTORCYCLE,
    "bicycle": VehicleKind.CYCLIST,
}
