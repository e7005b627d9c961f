"""OpenSCENARIO XML 1.2 with its OpenDRIVE road: `<name>.xosc` and `<name>.xodr`.

Everybody follows its trajectory by the clock. The target is the entity `Ego` and drives as it did; who puts a driver of its own
in its place leaves out the manoeuvre group `Ego`. As the standard asks, positions are those of the rear axle, REAR_AXLE of the
length behind the box's middle. Who comes later is added then, and who goes is deleted a step after its last one; gaps, in which
nobody saw it, are driven through. Signals and stop lines are not written.
"""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

import numpy as np
from scenariogeneration import xosc

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import unit
from drivegen.core.scenario import DT, SAFE_ID, Scenario, Trajectories, VehicleKind
from drivegen.exporters._opendrive import opendrive, serialised
from drivegen.exporters.base import About
from drivegen.store.files import write_bytes

ABOUT = About(title="OpenSCENARIO XML 1.2 with OpenDRIVE 1.5", read_by="programs that take OpenSCENARIO XML")

REAR_AXLE = 0.28
"""The rear axle is this share of the length behind the middle of a vehicle's box; a person has none."""

_CATEGORY = {
    VehicleKind.CAR: xosc.VehicleCategory.car,
    VehicleKind.TRUCK: xosc.VehicleCategory.truck,
    VehicleKind.BUS: xosc.VehicleCategory.bus,
    VehicleKind.MOTORCYCLE: xosc.VehicleCategory.motorbike,
    VehicleKind.CYCLIST: xosc.VehicleCategory.bicycle,
}
_FASTEST, _STRONGEST, _HARDEST = 70.0, 10.0, 12.0
_NO_DATE = datetime(2000, 1, 1)  # the format asks for one, and equal scenarios are to be equal bytes
_MASS = 75.0


class Plugin:
    """OpenSCENARIO XML."""

    def write(self, scenario: Scenario, motion: Trajectories, folder: Path, name: str) -> None:
        """See `base.Exporter`."""
        if not SAFE_ID.fullmatch(name):
            raise UnusableInput(f"{name!r} cannot name a file: use letters, digits, dots, dashes and underscores")
        for suffix, raw in ((".xodr", opendrive(scenario.map, name)), (".xosc", openscenario(scenario, motion, name))):
            write_bytes(folder / f"{name}{suffix}", raw)


def openscenario(scenario: Scenario, motion: Trajectories, name: str) -> bytes:
    """The scenario as an OpenSCENARIO file whose road is `<name>.xodr` beside it."""
    entities, init, act = xosc.Entities(), xosc.Init(), xosc.Act("traffic", _at(0.0))
    for who, kind, size, track in _everybody(scenario, motion):
        steps = np.flatnonzero(track.valid)
        entities.add_scenario_object(who, _body(who, kind, size))
        place = _places(track, kind, size)
        if steps[0] == 0:
            init.add_init_action(who, xosc.TeleportAction(place[0]))
            init.add_init_action(who, xosc.AbsoluteSpeedAction(float(track.speed[0]), _AT_ONCE))
        act.add_maneuver_group(_group(who, place, steps * DT, motion.steps))
    board = xosc.StoryBoard(init, _at((motion.steps - 1) * DT, "stop"))
    board.add_act(act)
    road = xosc.RoadNetwork(f"{name}.xodr")
    document = xosc.Scenario(
        name, "DriveGen", xosc.ParameterDeclarations(), entities, board, road, xosc.Catalog(), 2, creation_date=_NO_DATE
    )
    return serialised(document.get_element())


_AT_ONCE = xosc.TransitionDynamics(xosc.DynamicsShapes.step, xosc.DynamicsDimension.time, 0)


def _everybody(scenario: Scenario, motion: Trajectories) -> Iterator[tuple[str, VehicleKind, np.ndarray, Trajectories]]:
    people = scenario.context
    for prefix, kinds, sizes, tracks in (
        ("Vehicle", scenario.vehicles.kind, scenario.vehicles.size, motion),
        ("Person", people.kind, people.size, people.motion),
    ):
        for n in np.flatnonzero(tracks.valid.any(-1)).tolist():
            who = "Ego" if prefix == "Vehicle" and n == 0 else f"{prefix}{n}"
            yield who, VehicleKind(int(kinds[n])), sizes[n], tracks[n]


def _body(who: str, kind: VehicleKind, size: np.ndarray) -> xosc.Vehicle | xosc.Pedestrian:
    length, width, height = (round(float(value), 3) for value in size)
    box = xosc.BoundingBox(width, length, height, _ahead(kind, length), 0, round(height / 2, 3))
    if kind == VehicleKind.PEDESTRIAN:
        return xosc.Pedestrian(who, _MASS, xosc.PedestrianCategory.pedestrian, box)
    rear, front = (xosc.Axle(0.6 * ahead, 0.7, width, place, 0.35) for ahead, place in ((0, 0), (1, round(0.6 * length, 3))))
    return xosc.Vehicle(who, _CATEGORY[kind], box, front, rear, _FASTEST, _STRONGEST, _HARDEST)


def _ahead(kind: VehicleKind, length: float) -> float:
    """[m] from the reference point to the middle of the box."""
    return 0.0 if kind == VehicleKind.PEDESTRIAN else round(REAR_AXLE * length, 3)


def _places(track: Trajectories, kind: VehicleKind, size: np.ndarray) -> list[xosc.WorldPosition]:
    """Reference points at the valid steps; headings without jumps."""
    heading = np.unwrap(track.heading[track.valid].astype(np.float64))
    point = track.position[track.valid].astype(np.float64) - _ahead(kind, round(float(size[0]), 3)) * unit(heading)
    return [
        xosc.WorldPosition(*(round(v, 4) for v in (x, y, 0.0, h)))
        for (x, y), h in zip(point.tolist(), heading.tolist(), strict=True)
    ]


def _group(who: str, place: list[xosc.WorldPosition], times: np.ndarray, steps: int) -> xosc.ManeuverGroup:
    """Who follows its trajectory: from its first step on, and gone at the one after its last, in which it may collide."""
    group, manoeuvre = xosc.ManeuverGroup(who), xosc.Maneuver(who)
    first, last = float(times[0]), float(times[-1])
    group.add_actor(who)
    if first > 0:
        manoeuvre.add_event(_event(f"{who} comes", xosc.AddEntityAction(who, place[0]), first))
    if len(place) > 1:
        trajectory = xosc.Trajectory(who, False)
        trajectory.add_shape(xosc.Polyline([round(t, 1) for t in times.tolist()], place))
        follow = xosc.FollowTrajectoryAction(trajectory, xosc.FollowingMode.position, xosc.ReferenceContext.absolute, 1, 0)
        manoeuvre.add_event(_event(f"{who} drives", follow, first))
    if last < (steps - 1) * DT - DT / 2:
        manoeuvre.add_event(_event(f"{who} goes", xosc.DeleteEntityAction(who), last + DT))
    group.add_maneuver(manoeuvre)
    return group


def _event(name: str, action: object, time: float) -> xosc.Event:
    event = xosc.Event(name, xosc.Priority.parallel)
    event.add_action(name, action)
    event.add_trigger(_at(time))
    return event


def _at(time: float, point: str = "start") -> xosc.ValueTrigger:
    condition = xosc.SimulationTimeCondition(round(time, 1), xosc.Rule.greaterOrEqual)
    return xosc.ValueTrigger(f"{point} at {time:.1f} s", 0, xosc.ConditionEdge.none, condition, point)
