"""What is said back reads the same: every kind of road, and traffic."""

import contextlib
import os

import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.words.edits import EDITS, edited
from drivegen.words.offer import EXAMPLES
from drivegen.words.read import read
from drivegen.words.saying import sentences
from drivegen.words.table import table
from drivegen.words.traffic import request_sentences
from tests.words.sayable import ROADS, requests, specifications

EXAMPLES_EACH = 60 if "DRIVEGEN_FUZZ" in os.environ else 20
"""Sixty take about 27 CPU seconds, twenty a third of that."""

THOROUGH = settings(max_examples=EXAMPLES_EACH, phases=[Phase.generate], deadline=None, suppress_health_check=list(HealthCheck))


@pytest.mark.parametrize("roads", ROADS, ids=range(len(ROADS)))
def test_a_specification_that_is_said_reads_the_same(roads):
    @THOROUGH
    @given(specifications(roads))
    def check(spec):
        assume(spec is not None)
        assert read(" ".join(sentences(spec)), 7).road == spec

    check()


@THOROUGH
@given(requests())
def test_a_request_that_is_said_reads_the_same(asked):
    assume(asked)
    assert read(" ".join(request_sentences(asked)), 7).traffic == asked


UNEVEN = (
    "a Y-junction at 60 degrees",
    "a road with four signalised crossings 400 feet apart",
    "a trumpet",
    "a car overtaking me",
)


@pytest.mark.parametrize("text", [*EXAMPLES, *UNEVEN])
def test_every_example_is_read_and_what_it_says_reads_the_same(text):
    words = read(text, 7)
    again = read(" ".join(words.sentences()), 8)
    assert again == words


@THOROUGH
@given(st.sampled_from(EDITS), st.sampled_from(EXAMPLES[:18]))
def test_an_edited_specification_can_be_said(edit, text):
    spec = read(text, 7).road
    with contextlib.suppress(UnusableInput):  # declined, with an edit to try
        after = edited(spec, edit)
        assert read(" ".join(sentences(after)), 7).road == after


def test_every_form_of_the_table_is_well_formed():
    from drivegen.words.forms import stemmed

    for name in ("roads", "lines", "traffic", "edits", "cannot"):
        for phrase in table(name):
            assert phrase.forms
            assert all(stemmed(form) for form in phrase.forms)
            assert phrase.kind != "fact" or phrase.scope
