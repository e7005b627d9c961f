"""netconvert behind limits."""

import pytest

from drivegen.core.errors import MissingTool
from drivegen.sumo import netconvert
from drivegen.sumo.plain import Edge, Node, PlainNetwork


def road(lanes: int = 1, target: str = "b") -> PlainNetwork:
    nodes = [Node("a", 0, 0), Node("b", 100, 0)]
    return PlainNetwork(nodes, [Edge("ab", "a", target, lanes, 13.9)])


def test_a_network_is_built_without_date_and_twice_the_same() -> None:
    first = netconvert.plain_to_net(road())
    assert first == netconvert.plain_to_net(road())
    assert b"<!--" not in first
    assert b'id="ab_0"' in first


def test_what_netconvert_refuses_comes_back_in_its_own_words() -> None:
    with pytest.raises(netconvert.NetconvertRefused) as refusal:
        netconvert.plain_to_net(road(target="nowhere"))
    assert any("nowhere" in message for message in refusal.value.messages)


def test_a_crash_of_netconvert_is_an_error_of_ours() -> None:
    with pytest.raises(netconvert.NetconvertRefused) as refusal:
        netconvert.plain_to_net(road(lanes=-1))
    assert refusal.value.exit_code == 2


def test_a_run_that_takes_too_long_is_stopped() -> None:
    with pytest.raises(netconvert.NetconvertRefused, match="stopped after"):
        netconvert.convert(road().files(), ["-n", "net.nod.xml", "-e", "net.edg.xml", "-o", "o.net.xml"], "o.net.xml", 0.001)


def test_missing_netconvert_is_said_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    netconvert._installed.cache_clear()
    monkeypatch.setattr(netconvert.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingTool, match="pip install eclipse-sumo"):
        netconvert.plain_to_net(road())
    netconvert._installed.cache_clear()


def test_what_it_says_of_a_map_in_degrees_is_about_the_map() -> None:
    nodes = "".join(f"<node id='{i}' lat='{52 + i / 1000}' lon='9'/>" for i in (1, 2))
    path = "<way id='3'><nd ref='1'/><nd ref='2'/><tag k='highway' v='footway'/></way>"
    osm = f"<osm version='0.6'>{nodes}{path}</osm>".encode()
    with pytest.raises(netconvert.NetconvertRefused) as refused:
        netconvert.convert({"a.osm": osm}, ["--osm-files", "a.osm", "--proj.utm", "-o", "out.net.xml"], "another.xml")
    assert not any("proj.db" in message for message in refused.value.messages)
