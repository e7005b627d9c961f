"""Lines of a recording: on the ground, whole or dashed, and with no more points than can be seen."""

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from drivegen.core.geometry import Floats
from drivegen.core.rejections import Rejected
from drivegen.recording import colours

SEEN = 0.1
"""A line is drawn this exactly [m]: about a pixel of a view that is 100 m wide."""

DASH = 1.5
"""[m]."""


def flat(points: Floats, height: float = 0.0) -> NDArray[np.float32]:
    """Points (P, 2) of the ground as (P, 3)."""
    return np.concatenate([points, np.full((len(points), 1), height)], axis=1).astype(np.float32)


def closed(outline: Floats) -> Floats:
    """An outline (P, 2) as a line that ends where it begins."""
    return np.concatenate([outline, outline[:1]])


def thinned(line: Floats, tolerance: float = SEEN) -> Floats:
    """Those points of `line` (P, 2) from which the others differ by at most `tolerance` [m]; both ends are kept.

    Douglas and Peucker 1973: the farthest point from a chord is kept and splits it, until none is too far.
    """
    keep = np.zeros(len(line), np.bool_)
    keep[[0, -1]] = True
    chords = [(0, len(line) - 1)]
    while chords:
        a, b = chords.pop()
        if b - a < 2:
            continue
        between, chord = line[a + 1 : b] - line[a], line[b] - line[a]
        share = np.clip(between @ chord / max(float(chord @ chord), 1e-9), 0.0, 1.0)
        away = np.hypot(*(between - share[:, None] * chord).T)
        far = int(np.argmax(away))
        if away[far] > tolerance:
            keep[a + 1 + far] = True
            chords += [(a, a + 1 + far), (a + 1 + far, b)]
    return line[keep]


def log_rejected(recording: rr.RecordingStream, path: str, rejected: Rejected) -> None:
    """What was turned down, at `path`: thin dashes above all other lines, paler than what is illegal and stayed."""
    dashes = [flat(dash, 0.08) for dash in rejected.dashes(DASH)]
    if dashes:
        recording.log(path, rr.LineStrips3D(dashes, colors=[colours.REJECTED], radii=0.05), static=True)
