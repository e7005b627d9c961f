"""CommonRoad files written by hand: a road of two lanes that run into a crossing road, cars that drive along +x."""

from collections.abc import Iterable, Sequence

Point = tuple[float, float]


def xml(parts: Iterable[str], version: str = "2018b", step: str = "0.1") -> bytes:
    """A file of these elements."""
    head = f'<commonRoad commonRoadVersion="{version}" benchmarkID="USA_Tiny-1_1_T-1" timeStepSize="{step}">'
    return f'<?xml version="1.0" encoding="utf-8"?>\n{head}\n{"".join(parts)}</commonRoad>\n'.encode()


def points(line: Sequence[Point]) -> str:
    return "".join(f"<point><x>{x}</x><y>{y}</y></point>" for x, y in line)


def lanelet(name: int, left: Sequence[Point], right: Sequence[Point], inside: str = "", marking: str = "") -> str:
    mark = f"<lineMarking>{marking}</lineMarking>" if marking else ""
    bounds = f"<leftBound>{points(left)}{mark}</leftBound><rightBound>{points(right)}{mark}</rightBound>"
    return f'<lanelet id="{name}">{bounds}{inside}</lanelet>\n'


def state(step: float, x: float, y: float, heading: float = 0.0, speed: float | None = 5.0, tag: str = "state") -> str:
    velocity = "" if speed is None else f"<velocity><exact>{speed}</exact></velocity>"
    position = f"<position><point><x>{x}</x><y>{y}</y></point></position>"
    time = f"<time><exact>{step}</exact></time>"
    return f"<{tag}>{position}<orientation><exact>{heading}</exact></orientation>{time}{velocity}</{tag}>"


BOX = "<rectangle><length>4.5</length><width>1.8</width></rectangle>"


def obstacle(name: int, states: Sequence[str], kind: str = "car", shape: str = BOX, role: str = "dynamic") -> str:
    """An obstacle of 2018b; the first state is the initial one."""
    initial = states[0].replace("<state>", "<initialState>").replace("</state>", "</initialState>") if states else ""
    path = f"<trajectory>{''.join(states[1:])}</trajectory>" if len(states) > 1 else ""
    head = f"<role>{role}</role><type>{kind}</type><shape>{shape}</shape>"
    return f'<obstacle id="{name}">{head}{initial}{path}</obstacle>\n'


def car(name: int, x: float, y: float, speed: float = 5.0, steps: int = 60, dt: float = 0.1) -> str:
    """Drives along +x from (x, y)."""
    return obstacle(name, [state(t, round(x + t * dt * speed, 4), y, speed=speed) for t in range(steps)])


BESIDE_2 = '<adjacentLeft ref="2" drivingDir="same"/>'
BESIDE_1_AND_9 = '<adjacentRight ref="1" drivingDir="same"/><adjacentLeft ref="9" drivingDir="opposite"/>'

ROAD = (
    lanelet(
        1,
        [(0, 1.75), (50, 1.75), (100, 1.75)],
        [(0, -1.75), (100, -1.75)],
        f'<successor ref="3"/>{BESIDE_2}<speedLimit>13.4</speedLimit>',
    ),
    lanelet(2, [(0, 5.25), (100, 5.25)], [(0, 1.75), (100, 1.75)], BESIDE_1_AND_9),
    lanelet(3, [(100, 1.75), (130, 1.75)], [(100, -1.75), (130, -1.75)], '<predecessor ref="1"/><successor ref="77"/>'),
    lanelet(4, [(113, -40), (113, 40)], [(117, -40), (117, 40)]),
    lanelet(9, [(100, 5.25), (0, 5.25)], [(100, 8.75), (0, 8.75)]),
)
"""Lane 1 leads into 3, which 4 crosses; 2 lies to the left of 1, and 9 runs the other way; 77 is not in the file."""

CARS = (car(11, 20, 0), car(12, 40, 0, 8.0), car(13, 10, 3.5), obstacle(14, [state(0, 60, 8)], "parkedVehicle", role="static"))
