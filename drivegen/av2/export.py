"""Write one scenario in the official Argoverse 2 Motion Forecasting layout, which the av2 package's own loaders open.

`<folder>/<id>/scenario_<id>.parquet`, `log_map_archive_<id>.json` and, where there are signals, `signals_<id>.json`.
Beyond the official columns and keys: box sizes, who is a truck, lane speed limits and control, stop lines (`schema`, `maps`).
"""

from pathlib import Path

from drivegen.av2.maps import write_map
from drivegen.av2.signals import write_signals
from drivegen.av2.tracks import track_table
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import SAFE_ID, Scenario, Trajectories
from drivegen.store.files import write_bytes, write_table


def export_scenario(scenario: Scenario, motion: Trajectories, folder: Path, scenario_id: str) -> Path:
    """Write the scenario with its vehicles moving by `motion` (N, T) and return its folder `folder/scenario_id`.

    Context actors and signals go with it as logged; vehicles or steps that are not valid have no rows. Same scenario,
    same bytes. Raises UnusableInput where `scenario_id` cannot name a folder or `motion` has another shape.
    """
    if not SAFE_ID.fullmatch(scenario_id):
        raise UnusableInput(f"{scenario_id!r} cannot name a folder: use letters, digits, dots, dashes and underscores")
    if motion.valid.shape != (len(scenario.vehicles), scenario.steps):
        raise UnusableInput(f"scenario {scenario_id}: motion and vehicles differ in shape", reason="bad-trajectories")
    place = folder / scenario_id
    write_table(place / f"scenario_{scenario_id}.parquet", track_table(scenario, motion, scenario_id))
    write_bytes(place / f"log_map_archive_{scenario_id}.json", write_map(scenario.map))
    signals = place / f"signals_{scenario_id}.json"
    if len(scenario.signals):
        write_bytes(signals, write_signals(scenario.signals, scenario.map))
    else:
        signals.unlink(missing_ok=True)  # of a scenario that was there before
    return place
