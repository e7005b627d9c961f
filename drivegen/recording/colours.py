"""One palette for recordings (RGBA, 0-255), readable on a dark ground and with red-green weakness."""

Colour = tuple[int, int, int, int]

BACKGROUND: Colour = (17, 20, 26, 255)
ROAD: Colour = (58, 65, 78, 255)
BIKE_LANE: Colour = (40, 60, 56, 255)
MARKING: Colour = (150, 160, 176, 255)
CONNECTION: Colour = (104, 114, 132, 255)
KERB: Colour = (98, 108, 128, 255)
CROSSING: Colour = (170, 176, 188, 255)
STOP_LINE: Colour = (225, 229, 235, 255)
SIGNAL: tuple[Colour, ...] = ((120, 120, 120, 255), (63, 205, 130, 255), (250, 200, 60, 255), (240, 70, 80, 255))
"""By SignalState."""

TARGET: Colour = (255, 138, 61, 255)
SOCIAL: Colour = (77, 163, 255, 255)
CONTEXT: Colour = (180, 220, 90, 255)
ILLEGAL: Colour = (255, 64, 96, 255)
REJECTED: Colour = (255, 160, 178, 255)
LOGGED: Colour = (226, 232, 240, 110)
PLOTTED: Colour = (136, 146, 162, 255)
"""What a plot compares with: the viewer draws plots on a light ground, too."""

CANDIDATE: Colour = (190, 140, 255, 130)
TARGET_CANDIDATE: Colour = (255, 138, 61, 170)
CHOSEN: Colour = (208, 160, 255, 255)

DRIVER: tuple[Colour, ...] = (TARGET, (63, 205, 130, 255), (208, 160, 255, 255), (250, 200, 60, 255), (255, 160, 178, 255))
"""One driver each, neither blue as their neighbours nor white as the log."""


def drivers(count: int) -> list[Colour]:
    """A colour for each of `count` drivers; where there are more of them than colours these come again from the first."""
    return [DRIVER[n % len(DRIVER)] for n in range(count)]
