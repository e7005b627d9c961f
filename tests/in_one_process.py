"""Run every stage of the workspace in this process, one after the other: `python -m tests.in_one_process` in its folder.

DVC has run them before, each in a process of its own; dvc.lock holds their command lines, `stages/run WORD PATH...`.
"""

import shlex
from pathlib import Path

from flows import pipeline
from stages._door import enter


def main() -> None:
    """Raises SystemExit where a stage ends with an error, which it has said by then."""
    entries = pipeline.locked(Path())
    for stage in pipeline.read().needs:
        _, word, *paths = shlex.split(entries[stage]["cmd"])
        enter(word, *paths)


if __name__ == "__main__":
    main()
