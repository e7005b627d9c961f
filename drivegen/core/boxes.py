"""Oriented boxes for compiled loops: how deep two are in each other, how far apart, and what a moving one sweeps.

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
    return depth_of_turned(dx, dy, cos_a, sin_a, length_a, width_a, cos_b, sin_b, length_b, width_b)


@njit(cache=True)
def depth_of_turned(dx, dy, cos_a, sin_a, length_a, width_a, cos_b, sin_b, length_b, width_b):  # type: ignore[no-untyped-def]
    """`depth`, given cosines and sines of the headings."""
    cos, sin = abs(cos_a * cos_b + sin_a * sin_b), abs(sin_b * cos_a - cos_b * sin_a)
    la, wa, lb, wb = 0.5 * length_a, 0.5 * width_a, 0.5 * length_b, 0.5 * width_b
    on_a = min(la + lb * cos + wb * sin - abs(cos_a * dx + sin_a * dy), wa + lb * sin + wb * cos - abs(cos_a * dy - sin_a * dx))
    on_b = min(lb + la * cos + wa * sin - abs(cos_b * dx + sin_b * dy), wb + la * sin + wa * cos - abs(cos_b * dy - sin_b * dx))
    return min(on_a, on_b)


@njit(cache=True)
def separation(dx, dy, cos_a, sin_a, length_a, width_a, cos_b, sin_b, length_b, width_b):  # type: ignore[no-untyped-def]
    """Signed distance of two boxes [m]: how far apart they are, or minus how deep they are in each other.

    (dx, dy): from a's centre to b's; (cos, sin): their headings. Boxes that are apart are nearest at a corner of one of them.
    """
    la, wa, lb, wb = 0.5 * length_a, 0.5 * width_a, 0.5 * length_b, 0.5 * width_b
    cos, sin = cos_a * cos_b + sin_a * sin_b, sin_b * cos_a - cos_b * sin_a
    ax, ay = cos_a * dx + sin_a * dy, cos_a * dy - sin_a * dx
    bx, by = cos_b * dx + sin_b * dy, cos_b * dy - sin_b * dx
    c, s = abs(cos), abs(sin)
    on_a = min(la + lb * c + wb * s - abs(ax), wa + lb * s + wb * c - abs(ay))
    on_b = min(lb + la * c + wa * s - abs(bx), wb + la * s + wa * c - abs(by))
    deep = min(on_a, on_b)
    if deep >= 0:
        return -deep
    nearest = np.inf
    for along in (-1.0, 1.0):
        for across in (-1.0, 1.0):
            x, y = ax + along * lb * cos - across * wb * sin, ay + along * lb * sin + across * wb * cos
            nearest = min(nearest, max(abs(x) - la, 0.0) ** 2 + max(abs(y) - wa, 0.0) ** 2)
            x, y = along * la * cos + across * wa * sin - bx, across * wa * cos - along * la * sin - by
            nearest = min(nearest, max(abs(x) - lb, 0.0) ** 2 + max(abs(y) - wb, 0.0) ** 2)
    return np.sqrt(nearest)


@njit(cache=True)
def bounds(position, valid):  # type: ignore[no-untyped-def]
    """(B, 4) low x, low y, high x, high y of the valid steps; low above high where there are none."""
    boxes = np.empty((valid.shape[0], 4), np.float32)
    for b in range(valid.shape[0]):
        low_x = low_y = np.float32(np.inf)
        high_x = high_y = np.float32(-np.inf)
        for t in range(valid.shape[1]):
            if valid[b, t]:
                x, y = position[b, t, 0], position[b, t, 1]
                low_x, high_x = min(low_x, x), max(high_x, x)
                low_y, high_y = min(low_y, y), max(high_y, y)
        boxes[b, 0], boxes[b, 1], boxes[b, 2], boxes[b, 3] = low_x, low_y, high_x, high_y
    return boxes
