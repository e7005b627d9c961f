"""Stage gate: whether the new one of two drivers, or of two versions of one, collides more often than the old one.

argv: scenarios of one split, futures of them (folder of shards of samples), record (JSON, see `corner_cases.gate.Gate.record`).
Both drive through all futures, neighbours replayed. A worse driver is no failure here: the record says so, who asked decides.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivegen.corner_cases.gate import Settings, gate
from drivegen.drivers.shared.version import version
from drivegen.store.files import write_json
from drivegen.store.lookup import futures_in
from drivegen.store.scenarios import shards
from stages._door import require


@dataclass(frozen=True)
class Params:
    """`settings`: see their class; `drivers`: usual settings by name; `old`, `new`: one name each, with what differs."""

    seed: int
    settings: Settings
    drivers: dict[str, dict[str, Any]]
    old: dict[str, Any]
    new: dict[str, Any]


def main(params: Params, scenarios: Path, futures: Path, record: Path) -> dict[str, float]:
    """Drive, compare, write."""
    chosen = {"old": params.old, "new": params.new}
    old, new = (version(one, params.drivers, "gate.drivers", f"stages/params.yaml: gate.{name}") for name, one in chosen.items())
    pairs = [pair for shard in shards(require(futures, "run the rollout stages")) for pair in futures_in(shard, scenarios)]
    every = [(scenario, k, made.motion[k]) for scenario, made in pairs for k in range(len(made.dropped))]
    result = gate(old, new, every, params.settings, params.seed)
    names = (_name("the old", params.old), _name("the new", params.new))
    write_json(record, {"drivers": chosen, "folder": str(futures), **result.record(*names)})
    return {"runs": float(len(every))}


def _name(which: str, drivers: dict[str, Any]) -> str:
    return f"{which} {next(iter(drivers))}"
