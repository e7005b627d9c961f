"""Stage train_selector: learn the goal selector from the train split's lists, calibrate and score it on the validation split.

argv: scenarios (folder with val), lists (folder of stage goal_lists), model (folder), metrics (JSON), loss curve (CSV). The
metrics stand beside those of a uniform choice and of the hand-made prior on the same candidates. An interrupted training goes
on from `.drivegen/checkpoints/`, in a file named after everything that it depends on.
"""

import time
from dataclasses import asdict, dataclass
from pathlib import Path

from drivegen.core.first_frame import first_frame
from drivegen.goals.candidates import Settings as CandidateSettings
from drivegen.goals.candidates import candidates
from drivegen.goals.list_files import read_lists
from drivegen.goals.scores import Judged, judge, scores
from drivegen.roads.graph import LaneGraph
from drivegen.selectors.base import Selector
from drivegen.selectors.learned import Plugin, Settings
from drivegen.selectors.prior import Plugin as Prior
from drivegen.selectors.random import Plugin as Random
from drivegen.store.files import write_json
from drivegen.store.scenarios import read_shard, shards
from drivegen.training import checkpoint
from drivegen.training.curve import plateau, write_curve
from stages._door import SCRATCH, require

CHECKPOINTS = Path(".drivegen/checkpoints")


@dataclass(frozen=True)
class Params:
    """`candidates`: see `goals.candidates`; `learned`: see `selectors.learned`."""

    training_seed: int
    candidates: CandidateSettings
    learned: Settings


def main(params: Params, scenarios: Path, lists: Path, model: Path, metrics: Path, curve: Path) -> dict[str, float]:
    """Learn, save, score."""
    files = [require(lists, "run the goal_lists stage") / f"{split}.parquet" for split in ("train", "val")]
    (learnt, teacher), (held_out, _) = (read_lists(file, SCRATCH) for file in files)
    inputs = (asdict(params.learned), params.training_seed)
    name = checkpoint.name_of(inputs, files, checkpoint.source_digest("drivegen", "stages"))
    interrupted = CHECKPOINTS / f"selector-{name}.safetensors"
    began = time.process_time()
    selector, rows = Plugin.fit(learnt, held_out, params.learned, params.training_seed, interrupted, _say, teacher)
    took = time.process_time() - began
    selector.save(model)
    write_curve(curve, rows, error="goal_distance")
    counts = {"described": selector.described, "train_lists": len(learnt), "validation_lists": len(held_out)}
    learned = {"temperature": float(selector.net.temperature), "plateau": plateau(rows)}
    write_json(metrics, counts | learned | {"validation": _scores(scenarios / "val", params, selector)})
    interrupted.unlink(missing_ok=True)
    return {"training_cpu_seconds": took}


def _say(line: str) -> None:
    print(f"train_selector: {line}", flush=True)


def _scores(split: Path, params: Params, selector: Plugin) -> dict[str, dict[str, dict[str, float]]]:
    """Scores of the learned, the prior and the uniform choice, which all know the first frame alone."""
    compared: dict[str, Selector] = {"learned": selector, "prior": Prior(), "random": Random()}
    judged: dict[str, list[Judged]] = {name: [] for name in compared}
    for shard in shards(split):
        for scenario in read_shard(shard):
            graph, shown = LaneGraph.of(scenario.map), first_frame(scenario)
            offered = [candidates(graph, shown, n, params.candidates) for n in range(len(shown.vehicles))]
            for name, each in compared.items():
                judged[name].append(judge(scenario, offered, each.rank(graph, shown, offered)))
    return {name: scores(Judged.joined(parts)) for name, parts in judged.items()}
