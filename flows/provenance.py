"""What a workspace that is made anew keeps of the one before, and of which code it is."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flows.pipeline import locked

COSTS = Path(".drivegen/costs")
CODE = Path(".drivegen/code.json")

_MAKES_RUNS = ("drivegen", "stages", "dvc.yaml", "params.yaml", "constraints.txt")
"""What runs depend on: other files may differ from the commit."""


@dataclass(frozen=True)
class Times:
    """What stages took, by the file's name, and what dvc.lock said of each stage then."""

    files: dict[str, bytes]
    stages: dict[str, Any]

    @classmethod
    def of(cls, root: Path) -> "Times":
        """Those of the workspace `root`; none where there is no such folder."""
        return cls({file.name: file.read_bytes() for file in (root / COSTS).glob("*.parquet")}, locked(root))

    def put_back(self, root: Path) -> None:
        """Write those of stages that came back from the cache as they were: a stage that does not run is not timed again."""
        same = [name for name, entry in locked(root).items() if self.stages.get(name) == entry]
        for name, times in self.files.items():
            file = root / COSTS / name
            if not file.exists() and any(_is_of(file.stem, stage) for stage in same):
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(times)


def note_code(source: Path, root: Path) -> None:
    """Record in the workspace `root` the commit of `source`, and whether files that runs depend on differ from it.

    Both are null where git cannot tell.
    """
    commit, changes = _git(source, "rev-parse", "HEAD"), _git(source, "status", "--porcelain", "--", *_MAKES_RUNS)
    file = root / CODE
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(
        json.dumps({"commit": commit or None, "changed": None if commit is None or changes is None else bool(changes)})
    )


def _git(source: Path, *words: str) -> str | None:
    """What git answers, None where it cannot."""
    try:
        done = subprocess.run(["git", *words], cwd=source, capture_output=True, text=True, timeout=60, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def _is_of(cost: str, stage: str) -> bool:
    """Whether costs `<stage>-<item>`, or `<stage>-<item>-<part>`, are of dvc.lock's `<stage>@<item>`, or of one without items.

    Stages of another dvc.yaml have its path before their name: `stages/dvc.yaml:rank`.
    """
    name = stage.rpartition(":")[2].replace("@", "-", 1)
    return cost == name or cost.startswith(f"{name}-")
