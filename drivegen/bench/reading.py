"""Reading one scenario folder in the official Argoverse 2 layout, map included."""

import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from drivegen.av2.export import export_scenario
from drivegen.av2.folder import read_folder, scenario_files
from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds

VEHICLES = 24
"""Whole tracks in the file: as many rows as an Argoverse 2 scenario with its 50 or so fragmentary ones."""


@dataclass
class _State:
    """One vehicle at one step, as the av2 package keeps it."""

    timestep: int
    position: tuple[float, float]
    heading: float
    velocity: tuple[float, float]
    observed: bool


def rows() -> Iterator[Row]:
    """Three milliseconds are wanted; the reference makes an object per vehicle and step, as the av2 package does."""
    scenario = _scene.scene(0, VEHICLES)
    assert scenario.log is not None
    with tempfile.TemporaryDirectory() as name:
        folder = export_scenario(scenario, scenario.log, Path(name), "bench")
        value = best_cpu_seconds(lambda: read_folder(folder, "bench"), turns=10) * 1e3
        reference = best_cpu_seconds(lambda: _objects(folder), turns=2) * 1e3
    yield Row("read a scenario and its map", value, "ms", 3.0, True, reference, "an object per vehicle and step")


def _objects(folder: Path) -> tuple[dict[str, list[_State]], dict[str, list[np.ndarray[tuple[int, ...], np.dtype[np.float64]]]]]:
    tracks_file, map_file = scenario_files(folder)[:2]
    tracks: dict[str, list[_State]] = {}
    for row in pq.read_table(tracks_file).to_pylist():
        position, velocity = (row["position_x"], row["position_y"]), (row["velocity_x"], row["velocity_y"])
        tracks.setdefault(row["track_id"], []).append(
            _State(row["timestep"], position, row["heading"], velocity, row["observed"])
        )
    archive = json.loads(map_file.read_bytes())
    lanes = {
        name: [np.array([[p["x"], p["y"]] for p in lane[side]]) for side in ("left_lane_boundary", "right_lane_boundary")]
        for name, lane in archive["lane_segments"].items()
    }
    return tracks, lanes
