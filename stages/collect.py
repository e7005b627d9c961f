"""Stage collect: all results, what leads from them to their files, costs and calls in one DuckDB file with views (a leaf).

argv: folder of result parts, folder of those of single pieces, folder of cost parts, folder of calls of language models,
params.yaml, scenarios (a folder a split), new scenarios, shipped ones, samples (a folder a method), rounds of corner cases, table
of costs to write (Markdown), the DuckDB file to write. Costs and calls differ from run to run and so they stand here, outside of
what promises the same bytes for the same seed.
"""

from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa

from drivegen.core.scenario import SPLITS
from drivegen.core.settings import read_tree
from drivegen.lm.ledger import CALLS
from drivegen.report.costs import costs_markdown
from drivegen.store.costs import COST
from drivegen.store.files import whole
from drivegen.store.results import RESULT
from drivegen.warehouse.database import build, read_parts, result_parts
from drivegen.warehouse.tables import SAMPLES, parameter_table, read_recordings, read_sample_table, read_scenarios
from stages._door import require


@dataclass(frozen=True)
class Params:
    """The methods of each stage that generates."""

    own: tuple[str, ...]
    rivals: tuple[str, ...]
    baselines: tuple[str, ...]


def main(
    params: Params,
    results: Path,
    pieces: Path,
    costs: Path,
    calls: Path,
    parameters: Path,
    scenarios: Path,
    new: Path,
    shipped: Path,
    generated: Path,
    corner: Path,
    table: Path,
    out: Path,
) -> dict[str, float]:
    """Collect what lies below these folders; those that are absent hold nothing: a fresh checkout has no times, no calls."""
    parts = result_parts(require(results, "run the stages that measure")) + result_parts(pieces)
    tables = {
        "results": read_parts(parts, RESULT),
        "scenarios": read_scenarios({**{split: scenarios / split for split in SPLITS}, "new": new, "shipped": shipped}),
        "samples": _samples(params, generated, corner),
        "recordings": read_recordings(results / "recordings.json"),
        "parameters": parameter_table(read_tree(parameters)),
        "costs": read_parts(sorted(costs.glob("*.parquet")), COST),
        "calls": read_parts(sorted(calls.glob("*.parquet")), CALLS),
    }
    build(out, tables)
    with whole(table) as temporary:
        temporary.write_text(costs_markdown(out, results), encoding="utf-8")
    count = tables["results"].num_rows
    print(f"{out}: {count} results of {len(parts)} parts; costs in {table}")
    return {"results": float(count)}


def _samples(params: Params, generated: Path, corner: Path) -> pa.Table:
    """Every future by every method, and of every round of corner cases: a folder whose name is no number is a copy of one."""
    stages = {"rollout": params.own, "rollout_rival": params.rivals, "rollout_baseline": params.baselines}
    rolled_out = [read_sample_table(stage, name, generated / name) for stage, names in stages.items() for name in names]
    rounds = sorted((at.parent for at in corner.glob("*/samples") if at.parent.name.isdecimal()), key=lambda at: int(at.name))
    played = [read_sample_table("corner", folder.name, folder / "samples") for folder in rounds]
    return pa.concat_tables([SAMPLES.empty_table(), *rolled_out, *played])
