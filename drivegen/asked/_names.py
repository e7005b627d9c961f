"""What is called how: vehicles by kind, the target, who cannot be placed, and roads."""

from drivegen.asked._inflections import nouns
from drivegen.asked.request import Kind
from drivegen.assets.where import Relation

Entry = tuple[str, object]
"""A tag of the grammar, and the value that comes with it."""

_CARS = """car, motor car, motorcar, sedan, saloon, suv, taxi, cab, taxicab, automobile, auto, hatchback, van,
    minivan, pickup, pickup truck,
        jeep, estate car, station wagon, coupe, convertible, limousine, limo, roadster, sports car, police car, patrol car,
        passenger car, crossover, people carrier, mpv, delivery van, hire car, rental car, camper van, compact car, race
        car, car driver, taxi driver, van driver, panel van, city car, electric car"""
_TRUCKS = """truck, lorry, hgv, semi, semi truck, semi trailer, tractor trailer, articulated lorry, articulated truck,
        artic, 18 wheeler, tanker, tank truck, dump truck, dumper, dumper truck, garbage truck, rubbish truck, refuse truck,
        tow truck, box truck, fire truck, fire engine, juggernaut, big rig, heavy goods vehicle, goods vehicle, cement
        mixer, concrete mixer, road train, flatbed, delivery truck, delivery lorry, heavy truck, cement truck, car
        transporter, removal lorry, truck driver, lorry driver, tipper, freight truck, bin lorry, moving truck, trucker"""
_BUSES = """bus, coach, city bus, school bus, articulated bus, double decker, double decker bus, tour bus, shuttle bus,
        bendy bus, omnibus, trolleybus, public bus, bus driver, coach driver, tourist bus, intercity bus"""
_VEHICLES = "vehicle, driver, motorist"
_NOBODYS = """pedestrian, cyclist, bicycle, bike, motorbike, motorcycle, motorcyclist, moped, scooter, tram, train, trolley,
        deer, cow, dog, animal, child, man, woman, person, rider, biker, tractor, ambulance, trailer, minibus, crash,
        accident, obstacle"""
_ROADS = """road, street, highway, layout, motorway, freeway, expressway, arterial, avenue, boulevard, carriageway, alley,
        ramp, exit, curve, bend, roundabout, arm, leg, approach, zone, limit, speed limit, light, signal, traffic light,
        traffic signal, bus stop, bus station, bus bay, bus depot, truck stop, car park, car wash, parking lot, bus lane,
        truck lane, bridge, tunnel, merge lane, on ramp, off ramp, hill, slope, tarmac, kerb, curb, shoulder, hard shoulder,
        verge, town, city, village, map, scene, scenario, direction, side walk, sidewalk, crosswalk, zebra crossing, stop
        line, radius, width, entry, entrance"""
_JUNCTIONS = "junction, intersection, crossroads, crossroad, t junction, lights, traffic lights, next junction"

_NO_PLURALS = ("bus stops", "truck stops")
"A bus stops, too."

_EGO = (
    "ego",
    "target",
    "subject",
    "hero",
    "host",
    "test",
    "tested",
    "av",
    "adv",
    "own",
    "self driving",
    "autonomous",
    "automated",
)
_EGO_NOUNS = {"vehicle": None, "car": Kind.CAR, "truck": Kind.TRUCK, "bus": Kind.BUS, "lorry": Kind.TRUCK, "van": Kind.CAR}
_PERSONS = "us, me, we, ourselves, myself, you"


def targets() -> dict[str, Entry]:
    """Names of the target, with its kind if they say it."""
    found: dict[str, Entry] = dict.fromkeys(_PERSONS.split(", "), ("TARGET", ("", None)))
    for article in ("", "the ", "our ", "my ", "an ", "a "):
        found |= {
            f"{article}{ego}": ("TARGET", ("ego", None)) for ego in _EGO[:7] if not (article == "" and ego in ("test", "own"))
        }
        for noun, kind in _EGO_NOUNS.items():
            found |= {f"{article}{ego} {noun}": ("TARGET", ("ego", kind)) for ego in _EGO}
            if article in ("our ", "my "):
                found[f"{article}{noun}"] = ("TARGET", ("ego", kind))
    return found


def phrases(text: str) -> list[str]:
    """The phrases of a list with commas and line breaks."""
    return [" ".join(phrase.split()) for phrase in text.split(",")]


def vehicles() -> dict[str, Entry]:
    """Nouns of vehicles: kind, whether it is a plural, and where one with such a name stands."""
    found: dict[str, Entry] = {}
    for kind, names in ((Kind.CAR, _CARS), (Kind.TRUCK, _TRUCKS), (Kind.BUS, _BUSES), (Kind.VEHICLE, _VEHICLES)):
        for name in phrases(names):
            singular, plural = nouns(name)
            found |= {singular: ("KIND", (kind, False, None)), plural: ("KIND", (kind, True, None))}
    for word, place in (("leader", Relation.AHEAD), ("follower", Relation.BEHIND), ("tailgater", Relation.BEHIND)):
        found[word] = ("KIND", (Kind.VEHICLE, False, place))
    return found | dict.fromkeys(("somebody", "someone", "anybody", "something"), ("SOMEBODY", (Kind.VEHICLE, False, None)))


def others() -> dict[str, Entry]:
    """Nouns of what cannot be placed, and of roads."""
    found: dict[str, Entry] = {}
    for tag, names in (("NOBODY", _NOBODYS), ("ROAD", _ROADS), ("JUNCTION", _JUNCTIONS)):
        found |= {form: (tag, "") for name in phrases(names) for form in nouns(name) if form not in _NO_PLURALS} | found
    return found
