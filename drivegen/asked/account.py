"""Every single thing that was asked for, and whether it was got: rows for people, tables and success rates."""

from dataclasses import dataclass

import numpy as np

from drivegen.asked.achieved import does, queued, stands
from drivegen.asked.start import AskedStart
from drivegen.asked.wishes import Fill, says_how_many
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, VehicleKind
from drivegen.core.wording import many
from drivegen.goals.candidates import NO_ROUTE, Candidates
from drivegen.roads.line import Route
from drivegen.words.request import Density, Group, Kind, TrafficRequest

SPEED_SHARE = 0.2
"""A speed is met within this share of it, or within SPEED_LEAST [m/s]."""

SPEED_LEAST = 1.0

CROWD = 0.9
"""A density is met if this share of the vehicles stands within its radius."""


@dataclass(frozen=True)
class Item:
    """One thing that was asked for.

    Attributes:
        kind: of request: number, kind, density, speed, place, queue, or the manoeuvre's name. what: in words.
        got: whether it was. natural: the selector's own probability of the goals that realise a manoeuvre, None for others.
    """

    kind: str
    what: str
    got: bool
    natural: float | None = None


def first_frame(request: TrafficRequest, start: AskedStart, densities: dict[str, Fill]) -> list[Item]:
    """What is seen at the first frame: numbers, kinds, density, speeds, places, queues."""
    vehicles = start.scenario.vehicles
    items = _numbers(request, start)
    if request.density is Density.NONE:
        items.append(Item("density", "nobody but the target", len(vehicles) == 1))
    elif request.density is not None:
        radius = densities[request.density].radius
        away = np.hypot(*(vehicles.position - vehicles.position[TARGET]).T)
        got = bool((away <= radius + 1.0).sum() >= CROWD * len(start.cast))
        items.append(Item("density", f"{request.density.value}: {len(start.cast)} vehicles within {radius:g} m", got))
    if request.target_speed is not None:
        got = _near(float(vehicles.speed[TARGET]), request.target_speed)
        items.append(Item("speed", f"the target at {request.target_speed * 3.6:.0f} km/h", got))
    if request.speed is not None:
        free = np.array([i for i, n in enumerate(start.number) if _free(request, int(n), start.cast.group[n])], int)
        got = len(free) > 0 and _near(float(vehicles.speed[free].mean()), request.speed)
        items.append(Item("speed", f"about {request.speed * 3.6:.0f} km/h", got))
    routes = [keeping_routes(c) for c in start.free.candidates]
    for number, group in enumerate(request.groups):
        items += _of_group(start, number, group, routes)
    return items


def _free(request: TrafficRequest, number: int, group: int) -> bool:
    """Whether the asked vehicle `number` drives as everybody does."""
    if number == TARGET:
        return request.target_speed is None
    asked = request.groups[group] if group >= 0 else Group()
    return asked.manoeuvre is None and asked.speed is None and not asked.queue


def _numbers(request: TrafficRequest, start: AskedStart) -> list[Item]:
    placed = start.scenario.vehicles.kind[1:]
    items = []
    if says_how_many(request):
        items.append(Item("number", f"{many(request.vehicles, 'vehicle')} beside the target", len(placed) == request.vehicles))
    wanted = request.kinds
    for kind in (Kind.CAR, Kind.TRUCK, Kind.BUS):
        if wanted[kind]:
            number = int((placed == VehicleKind[kind.name]).sum())
            open_kinds = any(k is Kind.VEHICLE for k in start.cast.kinds[1:])
            got = number >= wanted[kind] if open_kinds else number == wanted[kind]
            items.append(Item("kind", f"{wanted[kind]} x {kind.value}", got))
    if request.target_kind not in (None, Kind.VEHICLE):
        got = bool(start.scenario.vehicles.kind[TARGET] == VehicleKind[request.target_kind.name])
        items.append(Item("kind", f"the target is a {request.target_kind.value}", got))
    return items


def _of_group(start: AskedStart, number: int, group: Group, routes: list[list[Route]]) -> list[Item]:
    members = [start.vehicle(n) for n, own in enumerate(start.cast.group) if own == number]
    wishes = [start.cast.wishes[n] for n, own in enumerate(start.cast.group) if own == number]
    vehicles, items = start.scenario.vehicles, []
    if group.place is not None:
        relations = [wish.relation or group.place for wish in wishes]  # who does something stands where that needs it
        heads = list(zip(members, relations, strict=True))[: 1 if group.queue else None]
        stand = all(v is not None and stands(routes, vehicles, v, relation, group.distance) for v, relation in heads)
        got = stand and None not in members
        distance = f" {group.distance:g} m" if group.distance is not None else ""
        where = ", ".join(dict.fromkeys(relation.value.replace("_", " ") for _, relation in heads))
        items.append(Item("place", f"{group.count} x {group.kind.value}{distance} {where}", got))
    if group.queue:
        there = [v for v in members if v is not None]
        items.append(Item("queue", f"{group.count} in a queue", len(there) == len(members) and queued(routes, vehicles, there)))
    if group.speed is not None:
        got = all(v is not None and _near(float(vehicles.speed[v]), group.speed) for v in members)
        items.append(Item("speed", f"{group.count} x {group.kind.value} at {group.speed * 3.6:.0f} km/h", got))
    return items


def manoeuvres(start: AskedStart, samples: Samples, k: int) -> list[Item]:
    """What is seen in sample k: manoeuvres, in time."""
    items = []
    routes = [keeping_routes(c) for c in start.free.candidates]
    target = _followed(start.ordered.choices.candidates[TARGET], int(samples.goal[k, TARGET]), routes[TARGET])
    done = {duty.vehicle: (duty, natural) for duty, natural in zip(start.duties, start.ordered.natural, strict=True)}
    for order in start.cast.orders:
        vehicle = start.vehicle(order.number)
        wording = order.manoeuvre.value.replace("_", " ") + (f" within {order.within:g} s" if order.within is not None else "")
        if vehicle is None or vehicle not in done:
            items.append(Item(order.manoeuvre.value, wording, False, 0.0))
            continue
        duty, natural = done[vehicle]
        got = not samples.dropped[k, vehicle] and does(duty, samples.motion[k], target, routes[vehicle], start.scenario.map)
        items.append(Item(order.manoeuvre.value, wording, bool(got), natural))
    return items


def keeping_routes(candidates: Candidates) -> list[Route]:
    """The vehicle's routes without lane changes, the likeliest first."""
    return [route for route in candidates.routes if route.lane_changes == 0]


def _followed(candidates: Candidates, goal: int, routes: list[Route]) -> list[Route]:
    """The target's routes that keep its lane, the one that its goal lies on first."""
    number = int(candidates.route[goal]) if goal >= 0 else NO_ROUTE
    if number != NO_ROUTE and candidates.routes[number].lane_changes == 0:
        return [candidates.routes[number], *routes]
    return list(routes)


def _near(speed: float, asked: float) -> bool:
    return abs(speed - asked) <= max(SPEED_LEAST, SPEED_SHARE * asked)
