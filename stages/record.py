"""Stage record: Rerun recordings of a few scenes drawn by seed, generated traffic against the log (a leaf).

argv: scenarios of one split, generated samples, the goals that they were drawn from, the folder of recordings, the list of
recordings (JSON, for the report: .rrd files differ in bytes at every write, their list does not).
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen.errors import UnusableInput
from drivegen.recordings import record_sample
from drivegen.store.draw import Drawn, draw_scenes
from drivegen.store.files import write_json
from drivegen.store.goals import GoalColumns, read_goals
from stages._door import enter, require


@dataclass(frozen=True)
class Params:
    """`scenes` recordings, the first of the scenes that the report draws."""

    seed: int
    scenes: int


def main(params: Params, scenarios: Path, generated: Path, goals: Path, out: Path, listing: Path) -> dict[str, float]:
    """Record sample 0 of each drawn scene."""
    require(generated, "run the rollout stage")
    links = []
    for drawn in draw_scenes(params.seed, scenarios, generated, params.scenes):
        scenario, samples = drawn.scenario, drawn.samples
        file = out / f"{scenario.scenario_id}.rrd"
        record_sample(file, scenario, samples, 0, _goals_of(drawn, goals))
        text = f"{scenario.scenario_id}, {scenario.city}: {samples.method} against the log"
        links.append({"text": text, "href": f"{out.name}/{file.name}"})
    write_json(listing, links)
    return {"scenarios": float(len(links))}


def _goals_of(drawn: Drawn, goals: Path) -> GoalColumns:
    shard = require(goals / drawn.shard, "run the goals stage")
    found = [one for one in read_goals(shard) if one.scenario_id == drawn.scenario.scenario_id]
    if not found:
        raise UnusableInput(f"{shard} lacks scenario {drawn.scenario.scenario_id}: run the goals stage again")
    return found[0]


if __name__ == "__main__":
    enter("record", Params, main)
