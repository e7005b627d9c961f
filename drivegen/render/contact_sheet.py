"""Pictures of one size in a grid, a title over each: one scene by every method."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]

TITLE = 26
"""Height of the strip above each picture [pixels]."""

GAP = 6
_INK, _GROUND = (30, 34, 40), 255


def contact_sheet(panels: Sequence[tuple[str, Image]], columns: int) -> Image:
    """(H, W, 3) with the titled (h, w, 3) RGB pictures in rows of `columns`; places that stay empty are white."""
    height, width = panels[0][1].shape[:2]
    rows = -(-len(panels) // columns)
    shape = (rows * (height + TITLE + GAP) - GAP, columns * (width + GAP) - GAP, 3)
    sheet = np.full(shape, _GROUND, np.uint8)
    for number, (title, picture) in enumerate(panels):
        top, left = number // columns * (height + TITLE + GAP), number % columns * (width + GAP)
        sheet[top + TITLE : top + TITLE + height, left : left + width] = picture
        cv2.putText(sheet, title, (left + 4, top + 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, _INK, 1, cv2.LINE_AA)
    return sheet
