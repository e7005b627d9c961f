"""What is read from a network that is none, and which roads lie on one another."""

import re

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.safe_xml import parse
from drivegen.layouts.spec import MapSpec
from drivegen.maps.examine import examine
from drivegen.maps.overlaps import overlapping
from drivegen.maps.structure import measure

ARMS = [{"angle": angle, "lanes_in": 3, "lanes_out": 3, "left_turn_lanes": 1} for angle in (0, 30, 90, 180, 270)]
NETWORK = examine(MapSpec.model_validate({"road": {"kind": "crossing", "arms": ARMS, "control": "signals"}})).network


@pytest.mark.parametrize(
    "nasty", [b'speed="fast"', b'speed="nan"', b'speed="1e400"', b'length="4 2"', b'shape="1,x 2,3"', b'shape=""']
)
def test_a_network_with_numbers_that_are_none_is_refused_in_a_sentence(nasty):
    at = NETWORK.index(b'<edge id="a0_in"')
    edge = NETWORK[at : NETWORK.index(b"</edge>", at)]
    broken = NETWORK.replace(edge, re.sub(nasty.split(b"=")[0] + b'="[^"]*"', nasty, edge))
    assert broken != NETWORK
    with pytest.raises(UnusableInput, match=r"map\.net\.xml: edge 'a0_in' has no finite shape"):
        measure(parse(broken, "map.net.xml"), "map.net.xml")


def test_lanes_near_the_junction_that_they_share_do_not_lie_on_one_another():
    assert overlapping(parse(NETWORK, "map.net.xml")) == ()
