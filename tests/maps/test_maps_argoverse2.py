"""Argoverse 2 maps as SUMO networks: every lane where it was, every link kept, on real maps and a made one."""

import os
from pathlib import Path

import numpy as np
import pytest

from drivegen.av2.maps import read_map
from drivegen.core.geometry import project
from drivegen.core.roadmap import RoadMap
from drivegen.maps.argoverse2 import to_network, to_plain
from drivegen.sumo.network import Network
from tests.scenes import straight_road


def real_maps() -> list[Path]:
    root = Path(os.environ.get("DRIVEGEN_REAL_DATA", Path(__file__).parents[3] / "shared" / "data"))
    return sorted((root / "argoverse2").glob("**/log_map_archive_*.json"))


def links_across_junctions(network: Network) -> set[tuple[str, str]]:
    """Links between lanes outside junctions, SUMO's internal lanes skipped."""
    after: dict[int, list[int]] = {}
    for a, b in network.map.links.tolist():
        after.setdefault(a, []).append(b)
    found = set()
    for lane in after:
        todo = list(after[lane]) if not network.map.in_junction[lane] else []
        while todo:
            following = todo.pop()
            if network.map.in_junction[following]:
                todo += after.get(following, [])
            else:
                found.add((network.lane_names[lane], network.lane_names[following]))
    return found


def sumo_names(road_map: RoadMap) -> dict[int, str]:
    """SUMO's name of every lane: the lane of the plain network that has its first and last point."""
    names = {}
    for edge in to_plain(road_map).edges:
        for index, lane in enumerate(edge.per_lane):
            names[lane.shape] = f"{edge.id}_{index}"
    lines = [road_map.centreline[i].astype(np.float64) + road_map.origin for i in range(len(road_map))]
    return {i: names[tuple((float(x), float(y)) for x, y in line)] for i, line in enumerate(lines)}


def assert_kept(road_map: RoadMap) -> None:
    network = Network.read(to_network(road_map), "test")
    names, index = sumo_names(road_map), {name: i for i, name in enumerate(network.lane_names)}
    shift = (network.map.origin - road_map.origin).astype(np.float64)
    for lane, name in names.items():
        line, back = road_map.centreline[lane].astype(np.float64), network.map.centreline[index[name]] + shift
        worst = [max(abs(project(b, point)[1]) for point in a) for a, b in ((line, back), (back, line))]
        assert max(worst) < 0.01, name
    assert links_across_junctions(network) == {(names[a], names[b]) for a, b in road_map.links.tolist()}


def test_a_made_map_keeps_lanes_and_links() -> None:
    assert_kept(straight_road())


@pytest.mark.parametrize("file", real_maps() or [None], ids=lambda f: f.stem[-12:] if f else "none")
def test_real_maps_keep_every_lane_within_a_centimetre_and_every_link(file: Path | None) -> None:
    if file is None:
        pytest.skip("no Argoverse 2 maps here: set DRIVEGEN_REAL_DATA")
    assert_kept(read_map(file.read_bytes(), file.name))


def test_lanes_between_which_changing_is_legal_share_a_road() -> None:
    road_map = straight_road()
    plain = to_plain(road_map)
    legal = int((road_map.may_change & road_map.same_direction).any())
    assert (max(edge.lanes for edge in plain.edges) > 1) == bool(legal)
