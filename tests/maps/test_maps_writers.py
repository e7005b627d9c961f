"""What every map writer keeps to: each file of the folder is tried the moment it exists."""

import pytest

from drivegen import plugins
from drivegen.errors import UnusableInput
from drivegen.maps.spec import MapSpec
from drivegen.maps.writers.base import MapWriter

WRITERS = plugins.names("maps.writers")


@pytest.fixture(params=WRITERS)
def writer(request: pytest.FixtureRequest) -> MapWriter:
    return plugins.load("maps.writers", request.param)()


def test_a_writer_says_who_it_is_and_draws_a_plain_crossing(writer: MapWriter) -> None:
    understanding = writer.write("a four-way intersection with traffic lights", 7)
    assert writer.description
    assert isinstance(understanding.spec, MapSpec)
    assert all(phrase and meaning for phrase, meaning in understanding.understood)


def test_a_writer_gives_the_same_specification_for_the_same_words_and_seed(writer: MapWriter) -> None:
    assert writer.write("a hairpin", 7) == writer.write("a hairpin", 7)


def test_a_writer_stops_where_no_road_is_described(writer: MapWriter) -> None:
    with pytest.raises(UnusableInput):
        writer.write("the meaning of life", 7)
