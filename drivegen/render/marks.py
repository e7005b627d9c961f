"""Place marks near what they mark, inside the picture, never over one another."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

RING = 3.0
"""Free places are looked for on circles this far apart [px]."""


def place_marks(
    anchors: NDArray[np.floating],
    half: NDArray[np.floating],
    gap: float,
    size: int | NDArray[np.int64],
    taken: NDArray[np.floating] | None = None,
) -> NDArray[np.float64]:
    """Centres (C, 2) [px] of upright boxes of half sizes `half` (C, 2): at `anchors` (C, 2) or at the nearest free place.

    Boxes lie wholly inside the picture of `size` (its side, or width and height) with at least `gap` pixels between them and
    from the boxes `taken` (B, 4: low x, low y, high x, high y), as long as the picture holds them; earlier ones choose first.
    """
    low, high = half + 1.0, size - half - 1.0
    inside = np.clip(np.asarray(anchors, np.float64), low, high)
    fixed = np.zeros((0, 4)) if taken is None else np.asarray(taken, np.float64)
    margin = gap / 2
    count = len(fixed)
    centres = np.concatenate([(fixed[:, :2] + fixed[:, 2:]) / 2, inside])
    halves = np.concatenate([(fixed[:, 2:] - fixed[:, :2]) / 2 + margin, half.astype(np.float64) + margin])
    low, high = (np.concatenate([fixed[:, :2], bound]) for bound in (low, high))
    placed: NDArray[np.float64] = _place(centres, halves, low, high, float(np.max(size)), count)[count:]
    return placed


@njit(cache=True)
def _place(wanted, half, low, high, size, fixed):  # type: ignore[no-untyped-def]
    """Each after the first `fixed` ones takes the first free place on growing circles around the wanted one."""
    placed = wanted.copy()
    for i in range(fixed, len(wanted)):
        ring, searching = 0, not _free(placed, half, i, wanted[i, 0], wanted[i, 1])
        while searching and ring * RING < 1.5 * size:
            ring += 1
            count = 8 + 4 * ring
            for k in range(count):
                angle = 2 * np.pi * k / count
                x, y = wanted[i, 0] + ring * RING * np.cos(angle), wanted[i, 1] + ring * RING * np.sin(angle)
                inside = low[i, 0] <= x <= high[i, 0] and low[i, 1] <= y <= high[i, 1]
                if inside and _free(placed, half, i, x, y):
                    placed[i, 0], placed[i, 1] = x, y
                    searching = False
                    break
    return placed


@njit(cache=True)
def _free(placed, half, i, x, y):  # type: ignore[no-untyped-def]
    """Whether box i at x, y overlaps none of those before it."""
    crowded = False
    for j in range(i):
        near_x = abs(placed[j, 0] - x) < half[i, 0] + half[j, 0]
        crowded |= near_x and abs(placed[j, 1] - y) < half[i, 1] + half[j, 1]
    return not crowded
