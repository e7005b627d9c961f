"""The question `goals-2`: one number a place, a picture that holds them, words that say what decides."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.core.geometry import to_vehicle_frame
from drivegen.core.roadmap import LaneControl
from drivegen.core.signals import Signals, SignalState
from drivegen.goals.candidates import MOST, candidates
from drivegen.goals.manoeuvres import Manoeuvre
from drivegen.goals.prior import GAP
from drivegen.goals.traffic import STAND
from drivegen.questions.account import odds
from drivegen.questions.asking import MOST_PIXELS, Settings
from drivegen.questions.goals import Case, about_vehicle
from drivegen.questions.goals_2 import places
from drivegen.questions.others import Others, pace
from drivegen.questions.places import with_stops
from drivegen.questions.ways import lane_end, lane_words, passages, way_words
from drivegen.questions.wordings import likeliest
from drivegen.render.goal_window import LONGEST_SIDE, Reach
from drivegen.roads.graph import LaneGraph
from drivegen.roads.parked import STANDING
from tests import scenes
from tests.models import candidate_settings, two_lanes

WORDING = likeliest("goals-2")
SETTINGS = candidate_settings()
CROSSING = scenes.busy_crossing()


def offered(scene, vehicle=0):
    return candidates(LaneGraph.of(scene.map), scene, vehicle, SETTINGS)


def told(scene, vehicle=0, c=None):
    case = Case.of(scene, vehicle, offered(scene, vehicle) if c is None else c, 7, WORDING)
    words, picture, _ = about_vehicle(case, 5, 768, (), WORDING).parts
    return case, words, cv2.imdecode(np.frombuffer(picture.content, np.uint8), cv2.IMREAD_COLOR)


def queue(gaps=(25, 33, 41), speeds=(0, 0, 0), own=8.0, control=LaneControl.SIGNAL, state=SignalState.RED):
    """A vehicle on its way to a line 70 m ahead, with others before it."""
    roads = scenes.crossing(arm=100.0, control=control)
    line = scenes.joined(roads, 0, 8, 4)
    log = [scenes.drive(line, 30, own, 101), *(scenes.drive(line, 30 + s, v, 101) for s, v in zip(gaps, speeds, strict=True))]
    lanes = np.arange(8, 20, dtype=np.int32)
    signals = Signals(lanes, np.full((12, 101), state, np.uint8)) if control == LaneControl.SIGNAL else Signals.none(101)
    return scenes.scenario(roads, scenes.stack(log), "queue", signals)


@pytest.mark.parametrize("scene", [CROSSING, two_lanes(14.0), queue()], ids=["crossing", "two lanes", "queue"])
def test_every_candidate_is_in_one_place_and_places_lie_apart(scene):
    for n in range(len(scene.vehicles)):
        c = offered(scene, n)
        found = places(scene, n, c)
        assert sorted(np.concatenate([place.members for place in found]).tolist()) == list(range(len(c)))
        shown = [place.shown for place in found]
        stays = [i for i in shown if c.manoeuvre[i] == Manoeuvre.STAY]
        assert len(stays) <= 1
        words = way_words(scene.map, scene.signals, c)
        gap = np.hypot(*(c.position[shown][:, None] - c.position[shown]).transpose(2, 0, 1))
        alike = np.array(
            [[words[a] == words[b] and (c.speed[a] < STANDING) == (c.speed[b] < STANDING) for a in shown] for b in shown]
        )
        assert (gap + 99 * ~alike + 99 * np.eye(len(shown))).min() > 1.5


def test_two_ways_to_stay_and_parking_in_the_lane_are_one_place_each():
    scene = queue(gaps=(9, 17), speeds=(0, 0), own=0.0)
    c = offered(scene)
    stays = np.flatnonzero(c.manoeuvre == Manoeuvre.STAY)
    twice = replace(c, **{f: np.concatenate([getattr(c, f), getattr(c, f)[stays]]) for f in list(c.__dataclass_fields__)[:11]})
    assert len(twice) > len(c)
    found = places(scene, 0, twice)
    assert len(found) == len(places(scene, 0, c))
    [home] = [p for p in found if stays[0] in p.members]
    assert len(c) in home.members


def test_what_a_place_gets_is_shared_by_its_candidates_as_the_usual_odds_have_them():
    usual = np.float32([0.1, 0.3, 0.0, 0.6])
    p = odds([np.array([0, 1]), np.array([2])], usual, 0.5, 1.0)
    assert p == pytest.approx([2 / 3 / 4, 2 / 3 * 3 / 4, 1 / 3, 0])
    assert odds([np.array([0, 1])], np.float32([0, 0, 1]), 0.5, 1.0) == pytest.approx([0.5, 0.5, 0])


@pytest.mark.parametrize("speed", [3.0, 14.0, 30.0])
def test_the_picture_holds_all_places_and_200_metres_at_least(speed):
    roads = scenes.straight_road(900, 3)
    scene = scenes.scenario(roads, scenes.stack([scenes.drive(scenes.joined(roads, 1), 100, speed, 101)]))
    case, words, image = told(scene)
    local = to_vehicle_frame(case.candidates.position[case.order], scene.vehicles.position[0], scene.vehicles.heading[0])
    reach = Reach.of(local)
    assert reach.holds(local).all()
    assert min(reach.forward + reach.back, reach.left + reach.right) >= 200
    assert reach.forward >= local[:, 0].max() + 5
    assert image.shape[0] * image.shape[1] == pytest.approx(768**2, rel=0.02)
    assert max(image.shape) <= LONGEST_SIDE
    assert "outside the picture" not in words
    farthest = max(int(metres) for metres in re.findall(r"\n\d+: (\d+) m ahead", words))
    assert farthest == round(float(local[:, 0].max()))


def test_words_say_what_decides_in_a_queue_at_a_red_signal():
    _, words, _ = told(queue())
    assert "Ahead in its lane: A after 20 m (stands), B after 28 m (stands), C after 36 m (stands)" in words
    assert "3 of them stand or creep before the junction" in words
    assert "straight on: the signal is red; turns left: the signal is red; turns right: the signal is red" in words
    assert re.search(r"close behind where A is now; \d+ m; stands", words)
    assert re.search(r"straight on, still in the junction, past A, B, C;", words)
    assert "The scene holds 4 vehicles" in words


@pytest.mark.parametrize(
    ("control", "expected"),
    [
        (LaneControl.UNKNOWN, "whether signals or signs hold there is not known"),
        (LaneControl.FREE, "it has right of way"),
        (LaneControl.YIELD, "it has to give way to others"),
        (LaneControl.STOP, "it has to stop and give way to others"),
    ],
)
def test_words_say_who_has_priority(control, expected):
    _, words, _ = told(queue(control=control))
    assert f"straight on: {expected}; turns left: {expected}" in words


def test_a_signal_of_unknown_colour_is_told_to_be_one():
    scene = queue()
    unseen = replace(scene, signals=Signals.none(101))
    assert "a signal whose colour is not known" in told(unseen)[1]
    unknown = np.full_like(scene.signals.state, SignalState.UNKNOWN)
    assert "a signal whose colour is not known" in told(replace(scene, signals=replace(scene.signals, state=unknown)))[1]


def test_turns_are_named_by_the_road_whatever_way_the_vehicle_points():
    for turn in (0.0, 0.15, -0.15):
        v = CROSSING.vehicles
        askew = replace(CROSSING, vehicles=replace(v, heading=v.heading + np.float32(turn)))
        c = offered(askew)
        heading = c.heading - CROSSING.vehicles.heading[0]
        words = way_words(askew.map, askew.signals, c)
        for i, said in enumerate(words):
            if "still" not in said and said not in ("keeps its lane", "stays where it is", "pulls over and parks"):
                expected = {0: "straight on", 1: "turns left", 3: "turns right"}[round(float(heading[i]) / (np.pi / 2)) % 4]
                assert said == expected
        assert set(words) >= {"straight on", "turns left", "turns right"}


def test_lanes_are_counted_from_the_right_and_changes_told():
    roads = scenes.straight_road(400, 3)
    assert [lane_words(roads, lane) for lane in range(3)] == ["lane 1 of 3", "lane 2 of 3", "lane 3 of 3"]
    scene = scenes.scenario(roads, scenes.stack([scenes.drive(scenes.joined(roads, 1), 50, 14, 101)]))
    c = offered(scene)
    for i, said in enumerate(way_words(roads, scene.signals, c)):
        lane = lane_words(roads, int(c.lane[i]))
        expected = {"lane 3 of 3": "changes one lane to the left", "lane 1 of 3": "changes one lane to the right"}
        assert said == expected.get(lane, said)
    assert "It is in lane 2 of 3, counted from the right." in told(scene)[1]


def test_the_end_of_a_lane_is_told_where_the_road_goes_on_beside_it():
    xs = np.arange(0, 201, 10.0)
    lines = [np.stack([x, np.full_like(x, y)], 1) for x, y in ((xs, 0.0), (xs, 3.5), (xs + 200, 3.5))]
    roads = scenes.road_map(lines, links=[(1, 2)], neighbours=[(1, 0)], whole=True)
    assert lane_end(roads, 0, 50.0, 300.0) == pytest.approx(150)
    assert lane_end(roads, 0, 50.0, 100.0) == lane_end(roads, 1, 50.0, 900.0) == np.inf
    scene = scenes.scenario(roads, scenes.stack([scenes.drive(scenes.joined(roads, 0), 50, 14, 101)]))
    assert "Its lane ends in 150 m, the road goes on beside it." in told(scene)[1]


@pytest.mark.parametrize("own", [9.0, 14.0])
def test_a_place_to_stop_is_added_where_there_is_none_at_the_line_or_behind_the_queue(own):
    added = 0
    for first in np.arange(38.0, 62.0, 1.5).tolist():
        scene = queue(gaps=(18, first, first + 8), speeds=(6.0, 0.0, 0.0), own=own)
        c = offered(scene)
        more = with_stops(scene, 0, c)
        added += len(more) - len(c)
        assert len(more) <= MOST
        for name in list(c.__dataclass_fields__)[:10]:
            assert np.array_equal(getattr(more, name)[: len(c)], getattr(c, name)), name
        assert float(more.prior.sum()) == pytest.approx(float(c.prior.sum()), rel=1e-5)
        assert (more.prior > 0).all()
        assert with_stops(scene, 0, more) is more
        for i in range(len(c), len(more)):  # as a candidate that the planner is given: on a route, within reach, standing
            on = c.route == more.route[i]
            assert c.s[on].min() - 1 <= more.s[i] <= c.s[on].max()
            assert more.speed[i] == 0
            assert more.step[i] == c.step[0]
            assert not more.leaves_map[i]
        stands = more.position[more.speed < STANDING]
        line = passages(scene.map, scene.signals, c.routes[0])[0].begin - 2.3 - STAND
        tail = first - 4.6 - 2 * GAP - 4.6  # less half of both cars, both gaps and the car between
        for s in (line, tail):
            if c.s.min() <= s <= c.s[c.route == 0].max():
                assert np.hypot(*(stands - scene.vehicles.position[0] - np.float32([s, 0])).T).min() <= 1.0
    assert added > 2


def test_others_have_letters_nearest_first_and_ways_and_speeds():
    case, words, _ = told(CROSSING, 4)
    others = Others.of(CROSSING, 4, Reach.of(np.zeros((1, 2))))
    away = np.hypot(*others.local.T)
    assert (np.diff(away) >= 0).all()
    assert list(others.letters.values()) == list("ABCDEFG")[: len(others.letters)]
    rows = re.findall(
        r"\n([A-Z]): (\w+)( \(the target\))?; (\d+) m (ahead|behind), (\d+) m (left|right); ([^;\n]+); ([^;\n]+)", words
    )
    assert len(rows) == int(others.inside.sum())
    for (letter, kind, target, *_, way, speed), n, turn in zip(rows, others.number, others.heading, strict=False):
        assert others.letters[int(n)] == letter
        assert kind == "car"
        assert bool(target) == (n == 0)
        assert speed == pace(float(CROSSING.vehicles.speed[n]))
        assert way != "oncoming" or abs(turn) > 2
    assert case.vehicle == 4


def test_who_is_outside_the_picture_is_counted():
    roads = scenes.straight_road(900, 1)
    line = scenes.joined(roads, 0)
    log = [scenes.drive(line, start, 3.0, 101) for start in (400, 420, 50, 850)]
    _, words, _ = told(scenes.scenario(roads, scenes.stack(log)))
    assert "Outside the picture the scene has 2 more." in words
    assert "The scene holds 4 vehicles, those nearest to the target, the farthest 450 m from it" in words


def rows_of(words):
    """The lines of the table of places."""
    return words[words.index("place: where") :].splitlines()[1:-1]


def test_in_its_own_lane_nobody_of_the_next_one_is_ahead():
    roads, own = scenes.straight_road(300, 3), 0
    for place in np.arange(54.0, 90.0, 3.0).tolist():
        log = [scenes.drive(scenes.joined(roads, lane), s, v, 101) for lane, s, v in ((1, 50, 1), (2, place, 0), (1, 120, 0))]
        _, words, _ = told(scenes.scenario(roads, scenes.stack(log)))
        beside = next(line[0] for line in words.splitlines() if "one lane to the left, same way" in line)
        in_lane = [row for row in rows_of(words) if "stays where it is" in row or "keeps its lane" in row]
        own += len(in_lane)
        assert not any(re.search(rf"(past|where) ([A-Z], )*{beside}\b", row) for row in in_lane)
    assert own


def test_nothing_is_as_fast_as_now_for_who_stands():
    rows = rows_of(told(queue(gaps=(60,), speeds=(0,), own=0.0))[1])
    assert any("creeps at" in row for row in rows)
    assert not any("as now" in row for row in rows)
    assert any("as now" in row for row in rows_of(told(queue(own=8.0))[1]))


def test_one_end_of_the_road_is_one_place():
    roads = scenes.straight_road(120, 1, whole=True)
    scene = scenes.scenario(roads, scenes.stack([scenes.drive(scenes.joined(roads, 0), 40, 14, 101)]))
    assert sum("leaves the map here" in row for row in rows_of(told(scene)[1])) == 1


def test_pictures_that_no_memory_holds_are_refused():
    for pixels in (255, MOST_PIXELS + 1):
        with pytest.raises(UnusableInput, match="pixels are 256 to 4096"):
            Settings("per_vehicle", pixels, 3, 1, 0.5, 0.7, 1.0, "", "")
