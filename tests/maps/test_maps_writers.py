"""What every map writer keeps to: each file of the folder is tried the moment it exists."""

import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.layouts.spec import MapSpec
from drivegen.words.writer import OFFLINE, writer_called


def test_the_writer_without_a_model_draws_and_says_what_it_read():
    writer = writer_called(OFFLINE)
    understanding = writer.write("a four-way intersection with traffic lights", 7)
    assert isinstance(understanding.spec, MapSpec)
    assert understanding.writer == writer.description
    assert understanding.sentences
    assert writer.write("a hairpin", 7) == writer.write("a hairpin", 7)
    with pytest.raises(UnusableInput, match="\ntry: "):
        writer.write("the meaning of life", 7)
    with pytest.raises(UnusableInput, match="only traffic"):
        writer.write("ten cars", 7)


@pytest.mark.parametrize("name", plugins.names("maps.writers"))
def test_a_writer_without_its_model_says_so(name):
    writer = writer_called(name)
    assert writer.description
    with pytest.raises(UnusableInput, match="there is no language model"):
        writer.write("a four-way intersection with traffic lights", 7)
