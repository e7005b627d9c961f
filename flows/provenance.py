"""What a workspace that is made anew keeps of the one before, and of which code it is."""

import json
import subprocess
from base64 import b64decode, b64encode
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flows.costs import COSTS, is_of
from flows.mending import write_whole
from flows.pipeline import locked

CODE = Path(".drivegen/code.json")

_MAKES_RUNS = ("drivegen", "stages", "flows", "dvc.yaml", "params.yaml", "pyproject.toml", "constraints.txt")
"""What runs depend on: other files may differ from the commit."""


@dataclass(frozen=True)
class Times:
    """What stages took: by the file's name its bytes, and the stage that it is of with what dvc.lock said of it then."""

    files: dict[str, tuple[bytes, str, Any]]

    @classmethod
    def of(cls, root: Path) -> "Times":
        """Those of the workspace `root`, and of those before it what was kept beside it; none where there is neither."""
        files, entries = _read_kept(_kept(root)), locked(root)
        for file in (root / COSTS).glob("*.parquet"):
            if stage := next((name for name in entries if is_of(file.stem, name)), None):
                files[file.name] = file.read_bytes(), stage, entries[stage]
        return cls(files)

    def keep(self, root: Path) -> None:
        """Write them beside the workspace `root`, for a run that is killed before it can put them back."""
        if self.files:
            kept = {name: [b64encode(times).decode(), *of] for name, (times, *of) in self.files.items()}
            write_whole(_kept(root), json.dumps(kept).encode())

    def put_back(self, root: Path) -> None:
        """Write those of stages that came back from the cache as they were: a stage that does not run is not timed again."""
        entries = locked(root)
        for name, (times, stage, entry) in self.files.items():
            file = root / COSTS / name
            if not file.exists() and entries.get(stage) == entry:
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(times)


def _kept(root: Path) -> Path:
    return root.with_name(f"{root.name}.costs.json")


def _read_kept(file: Path) -> dict[str, tuple[bytes, str, Any]]:
    """Nothing where there is no such file, or one that was damaged: what is lost is measured again when a stage runs again."""
    try:
        return {name: (b64decode(times), stage, entry) for name, (times, stage, entry) in json.loads(file.read_bytes()).items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


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
