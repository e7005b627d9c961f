"""Traffic signals of an Argoverse 2 folder, in a file of our own: the official layout has none, real ones have no file.

`signals_<id>.json` is `{"signals": [{"lane": 17, "states": "GGGYYRRR"}]}`: one letter per time step for the signal that
guards the entry into a lane of the map, U unknown, G green, Y yellow, R red.
"""

import numpy as np
import orjson
from numpy.typing import NDArray

from drivegen.core import safe_json
from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import RoadMap
from drivegen.core.signals import Signals

LETTERS = "UGYR"
"""The letter of each SignalState."""

_UNKNOWN_LETTER = 255
_STATE_OF = np.full(256, _UNKNOWN_LETTER, np.uint8)
_STATE_OF[np.frombuffer(LETTERS.encode(), np.uint8)] = np.arange(len(LETTERS))


def read_signals(raw: bytes, road_map: RoadMap, place: str) -> Signals:
    """Signals over the file's steps; those of lanes that a cropped map does not hold are left out.

    Raises UnusableInput, reason `bad-signals` or `too-large`, naming `place`.
    """
    index = {number: i for i, number in enumerate(road_map.lane_id.tolist())}
    try:
        tree = safe_json.parse(raw, place, "bad-signals")
        rows = [(index[row["lane"]], row["states"]) for row in tree["signals"] if row["lane"] in index]
        state = _states([letters for _, letters in rows])
    except (KeyError, TypeError, ValueError) as error:
        raise UnusableInput(f"{place} is no signals file: {error}", reason="bad-signals") from None
    return Signals(np.array([lane for lane, _ in rows], np.int32), state)


def _states(rows: list[str]) -> NDArray[np.uint8]:
    """(G, T) from G strings of T letters. Raises ValueError for unequal lengths and for unknown letters."""
    if len(set(map(len, rows))) > 1:
        raise ValueError("its signals last for different times")
    letters = np.frombuffer("".join(rows).encode("ascii"), np.uint8)
    state = _STATE_OF[letters].reshape(len(rows), -1 if rows else 0)
    if (state == _UNKNOWN_LETTER).any():
        raise ValueError(f"a state is none of {', '.join(LETTERS)}")
    return state


def write_signals(signals: Signals, road_map: RoadMap) -> bytes:
    """The file's bytes; same signals, same bytes."""
    letter = np.array(list(LETTERS))
    rows = [
        {"lane": int(road_map.lane_id[lane]), "states": "".join(letter[state])}
        for lane, state in zip(signals.lane, signals.state, strict=True)
    ]
    return orjson.dumps({"signals": rows})
