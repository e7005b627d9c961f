"""Words of traffic: what is read from them, what is left for the road, what is refused."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.asked import language_model, offline
from drivegen.asked.request import Density, Group, Kind, Manoeuvre, TrafficRequest
from drivegen.asked.suite import as_meant, held_out, suite
from drivegen.assets.where import Relation
from drivegen.errors import UnusableInput
from drivegen.maps.build import build_map
from tests.lm.asking import model
from tests.lm.chat_server import Says, serving

SENTENCE = (
    "twelve cars, two trucks and a bus around the target, dense, about 40 km/h, one vehicle cutting in from the right "
    "within 3 seconds"
)
MEANT = TrafficRequest(
    groups=(
        Group(count=12, kind=Kind.CAR),
        Group(count=2, kind=Kind.TRUCK),
        Group(kind=Kind.BUS),
        Group(place=Relation.RIGHT, manoeuvre=Manoeuvre.CUT_IN, within=3.0),
    ),
    density=Density.DENSE,
    speed=40 / 3.6,
)


def test_the_whole_sentence_is_understood():
    read = offline.read(SENTENCE)
    assert as_meant(read.request, MEANT)
    assert read.rest in ("", "and")


@pytest.mark.parametrize(
    ("words", "group"),
    [
        ("a truck 30 m ahead of the target", Group(kind=Kind.TRUCK, place=Relation.AHEAD, distance=30)),
        ("two cars 60 feet behind us", Group(count=2, kind=Kind.CAR, place=Relation.BEHIND, distance=18.29)),
        ("a lorry in the left lane", Group(kind=Kind.TRUCK, place=Relation.LEFT)),
        ("three oncoming cars", Group(count=3, kind=Kind.CAR, place=Relation.ONCOMING)),
        ("the lead vehicle brakes hard", Group(place=Relation.AHEAD, manoeuvre=Manoeuvre.HARD_BRAKING)),
        ("a broken down bus ahead", Group(kind=Kind.BUS, place=Relation.AHEAD, manoeuvre=Manoeuvre.STOPPED)),
        ("a queue of five cars ahead", Group(count=5, kind=Kind.CAR, place=Relation.AHEAD, queue=True)),
        ("a car overtakes the target", Group(kind=Kind.CAR, manoeuvre=Manoeuvre.OVERTAKE)),
        (
            "an oncoming car turning left",
            Group(kind=Kind.CAR, place=Relation.ONCOMING, manoeuvre=Manoeuvre.TURN_LEFT_ACROSS),
        ),
        (
            "a van in the right lane changes to the left lane",
            Group(kind=Kind.CAR, place=Relation.RIGHT, manoeuvre=Manoeuvre.CHANGE_LEFT),
        ),
    ],
)
def test_places_and_manoeuvres(words, group):
    assert as_meant(offline.read(words).request, TrafficRequest(groups=(group,)))


def test_the_suite_is_read_as_its_author_meant_it():
    wrong = [r.text for r in suite() if not as_meant(offline.read(r.text).request, r.means)]
    assert len(suite()) >= 60
    assert len(wrong) <= 2, wrong


def test_a_road_keeps_its_own_words():
    for road in (
        "a four-way intersection with traffic lights, two lanes in each direction, limit 50 km/h",
        "a road with a bus lane and a car park",
        "a highway with three lanes, 120 km/h",
        "a roundabout, 40 m in diameter, one exit turns left",
    ):
        assert offline.read(road).rest == road
        assert not offline.read(road).request


def test_traffic_and_road_come_out_of_one_description_and_what_neither_takes_is_listed():
    read = offline.read(
        f"a four-way crossing with traffic lights, two lanes in each direction, 50 km/h; {SENTENCE}, and purple cows"
    )
    assert as_meant(read.request, MEANT)
    built = build_map(read.rest, 7)
    assert built.account["spec"]["road"]["kind"] == "crossing"
    assert built.account["ignored"] == ["purple", "cows"]
    assert all(arm["speed"] == pytest.approx(50 / 3.6, abs=0.05) for arm in built.account["spec"]["road"]["arms"])


def test_the_target_is_not_one_of_the_others():
    read = offline.read("the target is a truck, the ego turns left, four cars near the ego vehicle").request
    assert (read.target_does, read.vehicles) == (Manoeuvre.TURN_LEFT, 4)


@pytest.mark.parametrize("words", ["500 cars", "a truck 900 m ahead", "100 cars and 100 trucks"])
def test_what_is_understood_and_cannot_be_is_refused(words):
    with pytest.raises(UnusableInput, match="cannot be placed"):
        offline.read(words)


@given(st.text(max_size=80) | st.lists(st.sampled_from(SENTENCE.replace(",", " ,").split()), max_size=30).map(" ".join))
@settings(max_examples=60, deadline=None)
def test_any_words_give_a_request_or_a_refusal(words):
    try:
        read = offline.read(words)
    except UnusableInput:
        return
    assert TrafficRequest.model_validate(read.request.model_dump()) == read.request


def test_a_language_model_answers_with_the_same_type_and_the_rules_stand_in_for_it(tmp_path):
    answer = f'{{"request": {MEANT.model_dump_json()}, "understood": [{{"phrase": "a dozen autos", "meaning": "12 cars"}}]}}'
    with serving([Says(answer)]) as server:
        read = language_model.read("a roundabout with a dozen autos", model(tmp_path, server.url))
    assert read.request == MEANT
    assert read.rest.split() == ["a", "roundabout", "with", ","]
    assert read.reader == "language model little-model"
    with serving([Says('{"request": {"groups": [{"count": 900}]}}')]) as server:
        asked = model(tmp_path / "b", server.url)
        read = language_model.read("three cars", asked)
    assert read.request.vehicles == 3
    assert read.reader == f"{offline.READER}, for the language model little-model failed: invalid-answer"
    assert asked.ledger.outcomes == {"asked again": 2, "invalid-answer": 1}


def test_held_out_requests_say_how_they_fared_before_the_rules_were_mended():
    told = held_out()
    assert told["first_try"] < told["requests"]  # a suite that was passed at once would hold nothing out
    assert told["now"] >= told["first_try"]
    assert all((request.first_try is None) != request.held_out for request in suite())
