"""Run every stage of the workspace in this process, one after the other: `python -m tests.in_one_process` in its folder.

DVC has run them before, each in a process of its own; dvc.lock holds their command lines, `stages/run WORD PATH...`.
"""

import runpy
import shlex
import sys
from pathlib import Path

from flows import pipeline


def main() -> None:
    """Raises SystemExit where a stage ends with an error, which it has said by then."""
    entries = pipeline.locked(Path())
    for stage in pipeline.read().needs:
        _, word, *paths = shlex.split(entries[stage]["cmd"])
        sys.argv = [word, *paths]
        sys.modules.pop(f"stages.{word}", None)  # of the same door with other paths; runpy warns of it
        runpy.run_module(f"stages.{word}", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
