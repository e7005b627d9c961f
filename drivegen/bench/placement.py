"""New scenes: 16 vehicles placed on a grid of streets, in both modes; the target is 1000 scenes in 20 CPU-seconds."""

from collections.abc import Iterator

from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec
from drivegen.placement.gaps import measure_gaps
from drivegen.placement.place import MODES, PlaceSettings
from drivegen.placement.scenes import Initialiser, Settings
from drivegen.placement.table import build_table
from drivegen.sumo.network import Network

SCENES, VEHICLES = 50, 16


def rows() -> Iterator[Row]:
    """CPU milliseconds of a scene on a map of 3 x 3 crossings: places, speeds, signals, the map around the target."""
    scenes = [_scene.scene(number) for number in range(40)]
    table, gaps = build_table(scenes), measure_gaps(scenes)
    spec = MapSpec.model_validate({"road": {"kind": "grid", "rows": 3, "columns": 3, "lanes": 2, "control": "signals"}})
    network = Network.read(compile_map(spec), "benchmark grid")
    for mode in MODES:
        placing = PlaceSettings(
            mode=mode, road_ahead=120.0, radius=80.0, speed_spread=0.15, least_time_gap=0.8, standstill_gap=2.0, attempts=24
        )
        settings = Settings(VEHICLES, 100, {"car": 1.0}, 250.0, placing)
        initialiser = Initialiser(network, "grid", "benchmark", table, settings, gaps)

        def place(initialiser: Initialiser = initialiser) -> None:
            for number in range(SCENES):
                initialiser.scenario(number, _scene.SEED)

        value = best_cpu_seconds(place, 3) / SCENES * 1e3
        yield Row(f"new scene of {VEHICLES} vehicles, placement as in mode {mode}", value, "ms", 20.0, True)
