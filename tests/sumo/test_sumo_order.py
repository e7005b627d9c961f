"""Which way across a junction goes first, as netconvert's junctions say."""

from functools import cache

import numpy as np
import pytest

from drivegen.core.roadmap import LaneControl
from drivegen.sumo.netconvert import plain_to_net
from drivegen.sumo.network import Network
from drivegen.sumo.plain import Edge, Node, PlainNetwork

ARMS = {"w": (-100.0, 0.0), "s": (0.0, -100.0), "e": (100.0, 0.0), "n": (0.0, 100.0)}


@cache
def crossing(kind: str, main: int = 1) -> Network:
    """Four arms about a junction; those from west and east have the priority `main`, the others 1."""
    nodes = [Node("c", 0, 0, kind)] + [Node(arm, *place) for arm, place in ARMS.items()]
    priority = {arm: main if arm in "we" else 1 for arm in ARMS}
    edges = [Edge(*ends, 1, 13.9, priority[arm]) for arm in ARMS for ends in ((arm + "c", arm, "c"), ("c" + arm, "c", arm))]
    return Network.read(plain_to_net(PlainNetwork(nodes, edges)), kind)


def order(net: Network) -> set[tuple[str, str]]:
    """Pairs of ways, such as ("n>e", "s>n"): the first one waits."""
    links, inside = net.map.links.tolist(), net.map.in_junction
    before, after = {b: a for a, b in links if inside[b]}, {a: b for a, b in links if inside[a]}

    def name(lane: int) -> str:
        ends = []
        for onward in (before, after):
            end = lane
            while inside[end]:
                end = onward[end]
            ends.append(net.lane_names[end].replace("c", "")[0])
        return ">".join(ends)

    return {(name(a), name(b)) for a, b in net.map.yields_to.tolist()}


def test_right_goes_before_left_and_a_left_turn_waits_for_who_comes_the_other_way() -> None:
    found = order(crossing("right_before_left"))
    assert {("w>e", "s>n"), ("s>n", "e>w"), ("w>n", "e>w")} <= found
    assert not {("s>n", "w>e"), ("w>e", "n>s"), ("e>w", "w>n")} & found


def test_of_two_minor_arms_the_left_turn_waits_for_who_drives_straight_and_both_for_the_main_road() -> None:
    found = order(crossing("priority", main=9))
    assert {("s>w", "n>s"), ("s>w", "w>e"), ("n>s", "e>s"), ("e>s", "w>e")} <= found
    assert not {("n>s", "s>w"), ("w>e", "s>w"), ("e>s", "n>s"), ("w>e", "e>s")} & found


def test_both_halves_of_a_way_cut_in_two_have_its_order() -> None:
    net = crossing("priority", main=9)
    links, inside = net.map.links, net.map.in_junction
    halves = links[inside[links].all(axis=1)]
    assert len(halves)
    waits = [set(net.map.yields_to[net.map.yields_to[:, 0] == half, 1].tolist()) for half in halves[0]]
    assert waits[0] == waits[1] != set()


@pytest.mark.parametrize("kind", ["allway_stop", "zipper", "traffic_light", "unregulated"])
def test_where_everybody_stops_or_lights_say_it_signs_give_no_order(kind: str) -> None:
    net = crossing(kind)
    signed = np.isin(net.map.control, (LaneControl.YIELD, LaneControl.STOP))
    assert signed[net.map.yields_to[:, 0]].all()
    assert not order(net) & {pair[::-1] for pair in order(net)}
    assert kind == "traffic_light" or not order(net)
