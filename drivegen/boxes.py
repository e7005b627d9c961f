"""Oriented boxes for compiled loops: how deep two are in each other, and what a moving one sweeps.

With half sizes (la, wa), (lb, wb), centres d apart and headings differing by delta, boxes are apart iff one of the four
box axes separates them, and on a's long axis the sum of half extents is la + lb |cos delta| + wb |sin delta|. The
smallest of the four overlaps is how deep the boxes are in each other. `geometry.boxes_overlap` is the same on arrays.
"""

import numpy as np
from numba import njit


@njit(cache=True)
def depth(dx, dy, heading_a, length_a, width_a, heading_b, length_b, width_b):  # type: ignore[no-untyped-def]
    """How deep two boxes are in each other [m]; negative: apart by at least that. (dx, dy): from a's centre to b's."""
    cos_a, sin_a = np.cos(heading_a), np.sin(heading_a)
    cos_b, sin_b = np.cos(heading_b), np.sin(heading_b)
    cos, sin = abs(cos_a * cos_b + sin_a * sin_b), abs(sin_b * cos_a - cos_b * sin_a)
    la, wa, lb, wb = 0.5 * length_a, 0.5 * width_a, 0.5 * length_b, 0.5 * width_b
    on_a = min(la + lb * cos + wb * sin - abs(cos_a * dx + sin_a * dy), wa + lb * sin + wb * cos - abs(cos_a * dy - sin_a * dx))
    on_b = min(lb + la * cos + wa * sin - abs(cos_b * dx + sin_b * dy), wb + la * sin + wa * cos - abs(cos_b * dy - sin_b * dx))
    return min(on_a, on_b)


@njit(cache=True)
def bounds(position, valid):  # type: ignore[no-untyped-def]
    """(B, 4) low x, low y, high x, high y of the valid steps; low above high where there are none."""
    boxes = np.empty((valid.shape[0], 4), np.float32)
    for b in range(valid.shape[0]):
        boxes[b, :2] = np.inf
        boxes[b, 2:] = -np.inf
        for t in range(valid.shape[1]):
            if valid[b, t]:
                for axis in range(2):
                    boxes[b, axis] = min(boxes[b, axis], position[b, t, axis])
                    boxes[b, 2 + axis] = max(boxes[b, 2 + axis], position[b, t, axis])
    return boxes
