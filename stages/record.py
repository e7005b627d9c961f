"""Stage record: Rerun recordings of a few scenes drawn by seed, generated traffic against the log (a leaf).

argv: scenarios of one split, generated samples, goals that they were drawn from, the folder of recordings, the list of
recordings (JSON, for the report: .rrd files differ in bytes at every write, their list does not).
"""

from dataclasses import dataclass
from pathlib import Path

from drivegen.recording import record_scenario
from drivegen.store.draw import draw_scenes
from drivegen.store.files import write_json
from stages._door import enter, require


@dataclass(frozen=True)
class Params:
    """`scenes` recordings, the first of the scenes that the report draws."""

    seed: int
    scenes: int


def main(params: Params, scenarios: Path, generated: Path, out: Path, listing: Path) -> dict[str, float]:
    """Record sample 0 of each drawn scene."""
    require(generated, "run the rollout stage")
    links = []
    for scenario, samples in draw_scenes(params.seed, scenarios, generated, params.scenes):
        file = out / f"{scenario.scenario_id}.rrd"
        record_scenario(file, scenario, samples, sample=0)
        text = f"{scenario.scenario_id}, {scenario.city}: {samples.method} against the log"
        links.append({"text": text, "href": f"{out.name}/{file.name}"})
    write_json(listing, links)
    return {"scenarios": float(len(links))}


if __name__ == "__main__":
    enter("record", Params, main)
