"""The raster shows the map where it is, turned with the vehicle."""

import numpy as np
import pytest

from drivegen.roads.raster import CHANNELS, PIXELS, RasterMap, raster
from tests.scenes import crossing, road_map, straight_road

EXTENT = 128.0  # half a metre per pixel
MIDDLE = PIXELS // 2


def test_a_road_along_the_heading_is_a_vertical_band_of_its_width() -> None:
    surface = raster(RasterMap.of(straight_road(300, 2)), np.array([150.0, 0.0]), 0.0, EXTENT, ["surface"])[0] > 0
    across = np.flatnonzero(surface[MIDDLE])
    assert surface[:, across[0] : across[-1] + 1].all()
    # Lanes from 1.75 m right of the vehicle to 5.25 m left of it.
    assert across[0] == pytest.approx(MIDDLE - 5.25 * 2, abs=1.5)
    assert across[-1] == pytest.approx(MIDDLE + 1.75 * 2, abs=1.5)


def test_the_picture_turns_with_the_vehicle() -> None:
    roads = RasterMap.of(crossing())
    ahead = raster(roads, np.zeros(2), 0.0, EXTENT, CHANNELS)
    left = raster(roads, np.zeros(2), np.pi / 2, EXTENT, CHANNELS)
    # The crossing looks the same from all four sides, the turned picture must not differ but for rounding.
    assert np.mean((ahead[0] > 0) != (left[0] > 0)) < 0.01
    shown_left_of_it = raster(RasterMap.of(straight_road()), np.array([150.0, -20.0]), 0.0, EXTENT, ["surface"])[0]
    assert shown_left_of_it[:, :MIDDLE].any()
    assert not shown_left_of_it[:, MIDDLE:].any()


def test_driving_direction_is_brighter_ahead_on_a_lane() -> None:
    lines = raster(RasterMap.of(straight_road(100, 1)), np.array([50.0, 0.0]), 0.0, EXTENT, ["centrelines"])[0]
    column = lines.max(axis=1)
    assert column[MIDDLE - 40] > column[MIDDLE + 40] > 0


def test_an_empty_place_is_black_and_an_unknown_channel_is_named() -> None:
    roads = RasterMap.of(straight_road())
    assert not raster(roads, np.array([0.0, 5000.0]), 0.3, EXTENT, CHANNELS).any()
    with pytest.raises(ValueError, match="sidewalks"):
        raster(roads, np.zeros(2), 0.0, EXTENT, ["sidewalks"])


@pytest.mark.parametrize("spacing", [100, 3000, 6000])
def test_a_straight_lane_is_drawn_straight_however_far_apart_its_points_are(spacing):
    x = np.arange(-3000.0, 3001.0, spacing)
    lane = RasterMap.of(road_map([np.stack([x, 0 * x], 1)]))
    (image,) = raster(lane, np.zeros(2), np.deg2rad(25), 100.0, ("centrelines",))
    rows, columns = np.nonzero(image)
    slope, _ = np.polyfit(rows, columns, 1)
    assert np.rad2deg(np.arctan(slope)) == pytest.approx(-25, abs=0.5)
