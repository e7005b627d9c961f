"""Where pictures stand in a contact sheet."""

import numpy as np

from drivegen.render.contact_sheet import GAP, TITLE, contact_sheet


def test_pictures_stand_in_rows_under_their_titles():
    shades = [10, 60, 110]
    sheet = contact_sheet([("one", np.full((40, 50, 3), shade, np.uint8)) for shade in shades], columns=2)
    assert sheet.shape == (2 * (40 + TITLE) + GAP, 2 * 50 + GAP, 3)
    for shade, (row, column) in zip(shades, [(0, 0), (0, 1), (1, 0)], strict=True):
        top, left = row * (40 + TITLE + GAP) + TITLE, column * (50 + GAP)
        assert (sheet[top : top + 40, left : left + 50] == shade).all()
        assert (sheet[top - TITLE : top, left : left + 50] < 128).any()  # the title's ink
    assert (sheet[40 + TITLE + GAP :, 50 + GAP :] == 255).all()
