"""What would be read as something else is declined: edits, and descriptions, of which one word goes astray."""

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.words.edits import edited
from drivegen.words.read import read
from tests.words.test_words_read import KMH, declined


@pytest.mark.parametrize(
    ("road", "edit", "why"),
    [
        ("a motorway, 120 km/h", "increase the limit by 10 km/h", "by 10 kmh"),
        ("a motorway, 120 km/h", "reduce the limit by 20 km/h", "by 20 kmh"),
        ("a motorway, 120 km/h", "reduce by 20 km/h", "by 20 kmh"),
        ("a motorway, 120 km/h", "lower the limit by 10 km/h", "by 10 kmh"),
        ("a motorway, 120 km/h", "raise the limit by 10 mph", "by 10 mph"),
        ("a motorway, 120 km/h", "add 10 km/h", "add 10 kmh"),
        ("a roundabout with four arms", "reduce the ring limit by 5 km/h", "by 5 kmh"),
    ],
)
def test_an_edit_of_something_else_than_is_said_is_declined(road, edit, why):
    with pytest.raises(UnusableInput, match="\ntry: ") as refusal:
        edited(read(road, 7).road, edit)
    assert why in str(refusal.value)
