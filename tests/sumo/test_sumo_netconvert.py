"""netconvert behind limits."""

import pytest

from drivegen.errors import MissingTool
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
