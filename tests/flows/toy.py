"""A pipeline of shell commands with our stages' names, in a git repository of its own: what flows do, without the work."""

import subprocess
from pathlib import Path

DVC = """
stages:
  ingest:
    cmd: mkdir -p data && echo logs > data/scenarios
    params: [run.seed]
    outs: [data/scenarios]
  maps:
    cmd: mkdir -p data && grep -o 'seed.*' params.yaml > data/maps
    params: [run.seed]
    outs: [data/maps]
  place:
    cmd: cat data/maps data/scenarios > data/placed
    deps: [data/maps, data/scenarios]
    outs: [data/placed]
  ship:
    cmd: mkdir data/shipped && cp data/placed data/shipped/shard && echo '{"scenarios":1}' > data/ship.json
    deps: [data/placed]
    outs: [data/shipped]
    metrics: [data/ship.json]
  corner:
    foreach: ${rounds}
    do:
      cmd: cp ${item.before} data/round-${item.k} && echo '{"collision":${item.rate}}' > data/round-${item.k}.json
      deps:
      - ${item.before}
      outs:
      - data/round-${item.k}
      metrics:
      - data/round-${item.k}.json
"""

GATE = """
stages:
  gate:
    wdir: ..
    cmd: >-
      grep -q logs data/scenarios &&
      echo '{"finding":"FINDING","sentence":"FINDING{colon} in 3 runs","collisions":{"old":1,"new":2}}' > data/gate.json
    deps: [data/scenarios]
    outs: [data/gate.json]
""".replace("{colon}", ":")

PARAMS = """
run:
  seed: 7
rounds:
- {k: 0, before: data/scenarios, rate: 0.1}
- {k: 1, before: data/round-0, rate: 0.3}
- {k: 2, before: data/round-1, rate: 0.3}
- {k: 3, before: data/round-2, rate: 0.9}
"""

EVALUATE = """
  evaluate:
    foreach: ${run.own}
    do:
      cmd: echo ${item} ${run.training_seed} ${rollout.generation.temperature} > data/table-${item}
      deps:
      - data/scenarios
      params:
      - run.training_seed
      - rollout.generation.temperature
      outs:
      - data/table-${item}
"""

PUBLISH = """
  training_seed: 7
  sampling_seed: 7
  own: [drivegen, log]
rollout: {generation: {temperature: 1.0}}
tables:
  quality:
    seeds: [7, 8]
    sampling_seeds: [7]
    temperatures: [0.5]
    params: {run.seed: 3}
    data:
      toy: {folder: "", params: {}, folders: {}, front: true}
      absent: {folder: recordings, params: {}, folders: {}, front: false}
"""

DOOR = """#!/bin/sh
# What stages/run does, for the door `publish` alone: one line a table of every run.
set -eu
test "$1" = publish
mkdir -p "$3"
for table in "$2"/*/*/data/table-*; do echo "${table#"$2"/} $(cat "$table")"; done > "$3/pooled"
"""


def build_tables(folder: Path) -> Path:
    """Write a toy pipeline whose results can be pooled; it notes in `ingested` how often ingest was computed."""
    build(folder)
    counted = DVC.replace("echo logs >", f"echo once >> {folder}/ingested && echo logs >")
    (folder / "dvc.yaml").write_text(counted + EVALUATE)
    (folder / "params.yaml").write_text(PARAMS.replace("  seed: 7\n", "  seed: 7" + PUBLISH))
    (folder / "stages").mkdir()
    (folder / "stages" / "run").write_text(DOOR)
    (folder / "stages" / "run").chmod(0o755)
    return folder


def build(folder: Path) -> Path:
    """Write the toy pipeline into `folder`."""
    (folder / ".dvc").mkdir()
    (folder / ".dvc" / "config").write_text("[core]\n    analytics = false\n")
    (folder / "dvc.yaml").write_text(DVC)
    (folder / "params.yaml").write_text(PARAMS)
    (folder / ".gitignore").write_text("/data/*\n/.drivegen/\n")
    for command in (["git", "init", "-q"], ["git", "add", "-A"]):
        subprocess.run(command, cwd=folder, check=True)
    return folder


def keep_rounds(folder: Path, count: int) -> None:
    """Leave the first `count` rounds alone: a stage takes more than a second."""
    params = (folder / "params.yaml").read_text().splitlines(keepends=True)
    rounds = [line for line in params if line.startswith("- {k:")]
    (folder / "params.yaml").write_text("".join(line for line in params if line not in rounds[count:]))
