"""The rows of places in the question `goals-2`: where, by which way, past whom, how fast."""

from collections.abc import Sequence

from drivegen.core.geometry import to_vehicle_frame
from drivegen.core.roadmap import NO_LANE, LaneControl
from drivegen.goals.candidates import NO_ROUTE
from drivegen.goals.departures import Departures
from drivegen.goals.traffic import STAND
from drivegen.questions.goals import Case
from drivegen.questions.others import Others, pace, where
from drivegen.questions.places import Place
from drivegen.questions.ways import IN_LANE, STAYS, Passage, lane_words, passages, way_words
from drivegen.roads.line import Route
from drivegen.roads.parked import STANDING

AT_LINE = 2.0
"""Who stands with its front within this distance before a line [m] stands at it."""

SLOW = 2.0
"""A place past somebody in its lane who is slower than this [m/s] is told to be: whoever stands has to drive on first."""

BEHIND = 6.0
"""Who stands with its front within this distance of the next one's rear [m] stands close behind it."""

OTHERWISE, OTHERWISE_SHARE = 0.5, 0.15
"""An end speed that differs from the present one by less [m/s], and by less than this share of it more, is about the same."""

MOST_PAST = 4
"""Of those whom a place is past that are named."""


def table(case: Case, shown: Departures, others: Others, own: Sequence[Route]) -> str:
    """A line per place, by number; a place beyond an exit is where the vehicle leaves the map.

    `own` are the routes that begin in the vehicle's lane and keep to it, the likeliest first: of a place in that lane, whoever is
    ahead on the first of them counts, also where the place's own route leaves the lane farther on.
    """
    v, c, scenario = case.scenario.vehicles, case.candidates, case.scenario
    local = to_vehicle_frame(shown.place, v.position[case.vehicle], v.heading[case.vehicle])
    words = way_words(scenario.map, scenario.signals, c)
    queues, own_queue = [others.in_lane(route) for route in c.routes], others.in_lane(own[0]) if own else []
    lines = ["place: where; what the vehicle does, lane there; way along the road; speed there, against the present one"]
    for number, place in enumerate(case.places):
        i = place.shown
        at, queue = int(c.lane[i]), queues[c.route[i]] if c.route[i] != NO_ROUTE else []
        if own and words[i].startswith(IN_LANE):
            at, queue = own[0].pieces[0].lane if words[i] == STAYS else at, own_queue
        lane = "" if at == NO_LANE or shown.leaves[i] else lane_words(scenario.map, at)
        does = [words[i], *([lane] if lane else []), *_remarks(case, shown, others, queue, place)]
        way = f"{shown.way[i]:.0f} m" if c.route[i] >= 0 else "no lane"
        lines.append(f"{number}: {where(*local[i].tolist())}; {', '.join(does)}; {way}; {_speed(case, shown, place)}")
    return "\n".join(lines)


def _remarks(case: Case, shown: Departures, others: Others, queue: list[tuple[int, float, float]], place: Place) -> list[str]:
    """That it leaves the map there, stands at a line or behind somebody, has passed where those in the `queue` now are."""
    c, i = case.candidates, place.shown
    if shown.leaves[i]:
        after = shown.after[place.members]
        first, last = f"{after.min():.1f}", f"{after.max():.1f}"
        return [f"leaves the map here after {first} s" if first == last else f"leaves the map here after {first} to {last} s"]
    remarks = ["beyond the map"] if c.leaves_map[i] else []
    if c.route[i] == NO_ROUTE:
        return remarks
    s, half = float(c.s[i]), float(case.scenario.vehicles.size[case.vehicle, 0]) / 2
    waits = [p.begin for p in passages(case.scenario.map, case.scenario.signals, c.routes[c.route[i]]) if _may_wait(p)]
    if place.slowest < STANDING and any(0 <= line - half - s < AT_LINE + STAND for line in waits):
        remarks.append("at the line")
    past = [others.name(k) for k, at, speed in queue if at < s + half and speed < SLOW]
    if past:
        remarks.append(f"past {', '.join(past[:MOST_PAST])}{' and more' if len(past) > MOST_PAST else ''}")
    elif place.slowest < STANDING and queue and queue[0][2] < SLOW:
        nearest, at, _ = queue[0]
        if 0 <= at - float(others.length[nearest]) / 2 - half - s < BEHIND:
            remarks.append(f"close behind where {others.name(nearest)} is now")
    return remarks


def _may_wait(p: Passage) -> bool:
    return p.begin > 0 and p.control != LaneControl.FREE


def _speed(case: Case, shown: Departures, place: Place) -> str:
    """The end speed in words, against the limit and the present one."""
    c, i = case.candidates, place.shown
    speed, now = float(shown.speed[i]), max(float(case.scenario.vehicles.speed[case.vehicle]), 0.0)
    if speed < STANDING:
        return "stands" if place.fastest < STANDING else "stands or creeps"
    if c.route[i] != NO_ROUTE:
        route = c.routes[c.route[i]]
        limit = float(route.speed_limit[min(int(max(shown.way[i], 0.0)), len(route.speed_limit) - 1)])
        if speed > 1.05 * limit:
            return f"{pace(speed)}, above the limit of {limit:.0f} there"
    if now >= STANDING and abs(speed - now) < OTHERWISE + OTHERWISE_SHARE * now:
        return f"{pace(speed)}, as now"
    return f"{pace(speed)}, {'faster' if speed > now else 'slower'}"
