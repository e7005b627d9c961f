"""Turns of phrase that are put shortly before the rules read them."""

import pytest

from drivegen.maps.writers._reading import normalise
from drivegen.maps.writers._rewording import reworded, without_names


@pytest.mark.parametrize(
    ("text", "short"),
    [
        ("please leave exits out.", "no exits ."),
        ("entries and exits omitted", "no entries and no exits"),
        ("neither junction is signalised", "no traffic lights"),
        ("two straight streets intersect", "2 streets intersect"),
        ("at the 700 m mark", "at 700 m"),
        ("crossings at 0.5, 1 and 1.5 km", "crossings at 0.5 km , 1 km and 1.5 km"),
        ("all southbound", "one way"),
        ("one-directional", "one way"),
        ("Manhattan-style avenue", "avenue"),
        ("five lanes in between and four before", "5 lanes in between and 4 lanes before"),
        ("traffic has outgrown the old stop sign, so the town wants a roundabout", "the town wants a roundabout"),
        (
            "a bus lane and one direction for cars, the other for bicycles",
            "a bus lane and 1 direction for cars , the other for bicycles",
        ),
    ],
)
def test_what_is_said_sideways_is_put_shortly(text: str, short: str) -> None:
    assert reworded(normalise(text)) == short


def test_names_of_lanes_and_numbers_of_roads_are_roads() -> None:
    assert without_names("Quarry Lane meets the B480 from the north") == "Quarry Road meets the B480 road from the north"
    assert without_names("Single Lane, Bus Lane") == "Single Lane, Bus Lane"
