"""Other words for the same road draw the same road."""

import pytest

from drivegen.words.read import read


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
        ("a junction with three arms at 120 degrees", "three roads meeting at equal angles"),
        ("a junction of three roads that meet at 120 degrees", "three roads meeting at equal angles"),
    ],
)
def test_other_words_for_the_same_draw_the_same(text, plain):
    assert read(text, 7, "same").sentences() == read(plain, 7, "same").sentences()
    assert read(text, 7, "same").road == read(plain, 7, "same").road
