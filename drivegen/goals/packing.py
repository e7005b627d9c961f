"""Candidates of a scenario as flat columns for the store, and back."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import Scenario
from drivegen.goals.candidates import Candidates
from drivegen.goals.departures import departures
from drivegen.goals.traffic import Ahead
from drivegen.roads.graph import LaneGraph
from drivegen.roads.leaving import Exits
from drivegen.roads.line import Piece, Route, build_route
from drivegen.store.goals import GoalColumns

_PER_CANDIDATE = ("position", "heading", "speed", "route", "s", "d", "step", "manoeuvre", "lane", "leaves_map", "prior")


def pack(
    scenario: Scenario, selector: str, candidates: Sequence[Candidates], probabilities: Sequence[NDArray[np.float32]]
) -> GoalColumns:
    """Columns of all vehicles' candidates, one vehicle after the other, with where and when each leaves the map."""
    exits = Exits.of(scenario.map)
    shown = [departures(scenario, n, c, exits) for n, c in enumerate(candidates)]
    routes = [route for c in candidates for route in c.routes]
    pieces = [piece for route in routes for piece in route.pieces]
    ahead = [(a.leader_gap, a.leader_speed, a.red_s, a.entry_s) for c in candidates for a in c.ahead]
    columns = {name: np.concatenate([getattr(c, name) for c in candidates]) for name in _PER_CANDIDATE} | {
        "candidates": np.array([len(c) for c in candidates]),
        "probability": np.concatenate(list(probabilities)),
        "place": np.concatenate([one.place for one in shown]),
        "leaves_after": np.concatenate([one.after for one in shown]),
        "routes": np.array([len(c.routes) for c in candidates]),
        "offset": np.concatenate([c.offset for c in candidates]),
        "ahead": np.array(ahead, np.float64).reshape(-1, 4),
        "pieces": np.array([len(route.pieces) for route in routes], np.int32),
        "piece.lane": np.array([p.lane for p in pieces], np.int32),
        "piece.change": np.array([p.change for p in pieces], np.int32),
        "piece.metres": np.array([(p.begin, p.end, p.half_blend) for p in pieces], np.float64).reshape(-1, 3),
    }
    return GoalColumns(scenario.scenario_id, selector, columns)


def unpack(graph: LaneGraph, goals: GoalColumns) -> tuple[list[Candidates], list[NDArray[np.float32]]]:
    """The candidates of each vehicle and their probabilities, exactly as they were packed.

    Raises UnusableInput where the columns do not fit together or the map.
    """
    columns = goals.columns
    counts, route_counts = columns["candidates"].astype(int), columns["routes"].astype(int)
    total = int(counts.sum())
    whole = {name: columns[name] for name in (*_PER_CANDIDATE[1:], "probability")}
    metres, ahead = columns["piece.metres"].reshape(-1, 3), columns["ahead"].reshape(-1, 4)
    lengths = [
        *((len(columns[name]), 2 * total) for name in ("position", "place")),
        (len(columns["leaves_after"]), total),
        *((len(values), total) for values in whole.values()),
        (len(route_counts), len(counts)),
        *((len(values), route_counts.sum()) for values in (columns["offset"], ahead, columns["pieces"])),
        *((len(values), columns["pieces"].sum()) for values in (metres, columns["piece.lane"], columns["piece.change"])),
    ]
    if (
        any(have != want for have, want in lengths)
        or not ((columns["piece.lane"] >= 0) & (columns["piece.lane"] < len(graph))).all()
    ):
        raise UnusableInput(f"the goals of scenario {goals.scenario_id} do not fit its map: run the goals stage again")
    whole["position"] = columns["position"].reshape(-1, 2)
    routes = _routes(graph, columns["pieces"], columns["piece.lane"], columns["piece.change"], metres)
    first, first_route = np.cumsum([0, *counts]), np.cumsum([0, *route_counts])
    result = []
    for n in range(len(counts)):
        rows, own = slice(first[n], first[n + 1]), slice(first_route[n], first_route[n + 1])
        result.append(
            Candidates(
                **{name: whole[name][rows] for name in _PER_CANDIDATE},
                routes=tuple(routes[own]),
                ahead=tuple(Ahead(*(float(v) for v in row)) for row in ahead[own]),
                offset=columns["offset"][own],
            )
        )
    return result, [whole["probability"][a:b] for a, b in pairwise(first)]


def _routes(
    graph: LaneGraph,
    counts: NDArray[np.integer],
    lanes: NDArray[np.integer],
    changes: NDArray[np.integer],
    metres: NDArray[np.float64],
) -> list[Route]:
    pieces = [
        Piece(int(lane), float(begin), float(end), int(change), float(half))
        for lane, change, (begin, end, half) in zip(lanes, changes, metres, strict=True)
    ]
    ends = np.cumsum([0, *counts])
    return [build_route(graph, pieces[a:b]) for a, b in pairwise(ends)]
