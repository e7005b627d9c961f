"""Other words for the same road draw the same road."""

import pytest

from drivegen.words.read import read
from tests.words.test_words_read import KMH


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("the minor road cuts the major at 55 degrees", "the minor road crosses the major road at 55 degrees"),
        ("a roundabout, inscribed circle dia 32 m", "a roundabout with a diameter of 32 m"),
        ("a grid with nine intersections", "a 3 by 3 grid"),
        ("two roads that cross at 60 degrees", "two streets cross at 60 degrees"),
        ("a skewed intersection with 45 degrees between the roads", "two roads cross at 45 degrees"),
        ("a road with a right-hand bend followed by a left-hand bend", "a road that bends right then left"),
        (
            "a road with a 70-degree left turn followed by a 70-degree right turn",
            "a road that bends left 70 degrees, then right 70 degrees",
        ),
        ("an on-ramp followed by an off-ramp and a weaving lane between them", "a weaving section"),
        ("a diamond interchange where a highway passes under an arterial road", "a diamond interchange"),
        ("a half cloverleaf interchange", "a partial cloverleaf"),
        ("a boulevard with three streets that cross it", "a boulevard crossed by three side streets"),
        ("two roundabouts joined by a 200 m link road", "two roundabouts 200 m apart"),
        ("a crossing 200 m before a roundabout", "a crossing and, 200 m further, a roundabout"),
        ("a crossroads with 3 lanes inbound and 2 lanes outbound", "a crossroads with 3 incoming lanes and 2 outgoing lanes"),
        ("a crossroads with right before left rule", "a crossroads with right before left"),
        ("a freeway of 2 lanes each way, barrier down the middle", "a freeway of 2 lanes each way with a barrier"),
        ("the road I drive home on is simply straight", "a straight road"),
        ("a road with three streets joining it", "a road with three side streets"),
        ("two side roads join the main road from opposite sides", "two side roads join the main road on opposite sides"),
        ("a quarter-mile street", "a street of 0.25 miles"),
        ("a motorway with three lanes, exit ramp right side", "a motorway with three lanes and an exit on the right side"),
        ("a curved road for lane keeping", "a curved road"),
        (
            "a highway with three lanes that narrows to two lanes per direction",
            "a highway with three lanes that narrows to two lanes, the same on both carriageways",
        ),
        ("a road with two lanes each way crossing a street", "a road with two lanes each way that crosses a street"),
        ("a country lane that ends at a main road", "a side road joins a main road"),
        ("a motorway with two exits, 600 m apart", "a motorway with an exit and another exit 600 m later"),
        ("a motorway with one exit on each side", "a motorway with an exit, the same on both carriageways"),
        ("a motorway with an exit, and 300 m after the exit a lane ends", "a motorway with an exit and a lane drop 300 m later"),
        ("three crossings in a row, only the middle one has lights", "three crossings in a row, the second one has lights"),
        ("a crossing, two lanes each way on all four arms", "a crossing, two lanes each way"),
        ("a staggered junction: two T-junctions on opposite sides, 60 m apart", "a staggered junction offset by 60 m"),
        ("two roads with two lanes each merge into one with four lanes", "two two-lane roads merge into one with four lanes"),
        ("a star-shaped junction with six arms", "a junction with six arms"),
        ("two parallel avenues crossed by three streets", "a grid of two by three streets"),
        ("a grid of two roads running north-south and three roads running east-west", "a 3 by 2 grid"),
        ("a highway whose leftmost lane ends", "a highway that loses its left lane"),
        ("a Y-junction of three roads at equal angles", "a Y-junction at 120 degrees"),
        ("a road with bends", "a winding road"),
        ("a road with bends and a limit of 60 km/h", "a winding road with a limit of 60 km/h"),
        ("a road with tight bends", "a tight winding road"),
        ("a country road in curves", "a winding country road"),
        ("a road with several curves", "a winding road"),
        ("a road with bends of 45 degrees", "a winding road that bends by 45 degrees"),
        ("a road, 300 m long, bends left", "a road, 300 m long, that bends to the left"),
        ("a road that bends", "a road with a bend"),
        ("a street which curves gently", "a street with a gentle curve"),
        (
            "a Y-junction. The stem has two lanes each way. The branches have one lane each way",
            "a Y-junction, two lanes each way on the first arm",
        ),
        ("a Y-junction whose branches are 60 degrees apart", "a Y-junction at 60 degrees"),
        ("three rows of four crossings, 90 m apart", "a grid of 3 by 4, 90 m apart"),
        ("3 rows and 4 columns of signalised crossings", "a 3 by 4 grid with traffic lights"),
        ("a motorway where three lanes become two", "a three-lane motorway that narrows to two lanes"),
        ("a motorway where the left lane ends: three go down to two", "a three-lane motorway whose left lane ends"),
        ("a three-lane one-way street, lanes 3 m wide", "a one-way street of three 3 m lanes"),
        ("a road with two lanes eastbound and one westbound", "a road with two lanes ahead and one back"),
        ("an intersection between a four-lane avenue and a two-lane street", "a four-lane avenue crosses a two-lane street"),
        (
            "a diamond interchange between a freeway and a four-lane arterial",
            "a diamond interchange of a freeway and a four-lane arterial",
        ),
        ("start with a three-lane motorway at 130 km/h", "a three-lane motorway at 130 km/h"),
        ("a corridor with five intersections spaced every 300 m", "five crossings in a row, 300 m apart"),
        ("a T-junction. The side road must stop", "a T-junction with a stop sign on the side road"),
        ("a T-junction, the side road comes from the north", "a T-junction with the side road on the left"),
        (
            "a crossing, the main road runs east-west with three lanes each way",
            "a crossing, three lanes each way on the main road",
        ),
        ("two roads meet at 60 degrees", "two roads cross at 60 degrees"),
        ("three streets branching off one through road", "a main road with three side roads"),
        ("a residential street with three streets branching off", "a residential street with three side streets"),
        ("two country lanes join a main road at a crossroads", "a main road and a country lane meet at a crossroads"),
        ("a street that crosses another street", "a street crossing another street"),
        ("a country road that first bends left and then right", "a country road that bends left then right"),
        ("nine crossings in a square grid, 150 m between neighbouring crossings", "a 3 by 3 grid, 150 m apart"),
        ("a residential road ending in a cul-de-sac", "a residential road that ends in a cul-de-sac"),
        ("a grid with four streets running north to south and three running east to west", "a 3 by 4 grid"),
        ("a highway with a ramp merging onto it", "a ramp that joins a highway"),
        ("a roundabout in the centre of a town", "an urban roundabout"),
        ("a main street, 1.2 km, crossed by four side streets", "a main street 1.2 km long, crossed by four side streets"),
        ("a junction with three arms at 120 degrees", "three roads meeting at equal angles"),
        ("a junction of three roads that meet at 120 degrees", "three roads meeting at equal angles"),
    ],
)
def test_other_words_for_the_same_draw_the_same(text, plain):
    assert read(text, 7, "same").sentences() == read(plain, 7, "same").sentences()
    assert read(text, 7, "same").road == read(plain, 7, "same").road


def test_a_limit_everywhere_is_that_of_the_ring_too():
    assert read("a roundabout with a limit of 50 km/h everywhere", 7).road.road.ring_speed == 50 * KMH
    assert read("a roundabout with a limit of 50 km/h on all roads", 7).road.road.ring_speed == 30 * KMH


def test_a_divided_highway_is_fast_and_a_dual_carriageway_may_be_a_street():
    highway = read("a divided highway with three lanes per direction and an off-ramp", 7).road.road
    assert (highway.speed, read("a dual carriageway", 7).road.road.speed) == (120 * KMH, 50 * KMH)


def test_behind_a_place_that_is_said_a_road_goes_on():
    drop = read("a four-lane freeway that drops to two lanes after 1 km", 7).road.road
    assert (drop.events[0].position, drop.alignment.length) == (1000, 1250)
    assert read("a 1050 m long four-lane freeway that drops to two lanes after 1 km", 7).road.road.alignment.length == 1050
