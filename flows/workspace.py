"""A second workspace beside this one: the same tree, the same DVC cache, parameters of its own.

What runs there cannot disturb this workspace or its dvc.lock, and nothing that this one has computed is computed again.
"""

import copy
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml


def duplicate(source: Path, target: Path, params: Mapping[str, Any], cache: Path | None = None) -> None:
    """Copy the files that git knows or does not ignore to the new folder `target`, with `params` over those of params.yaml,
    and what has been compiled of them.

    DVC keeps its files in `cache`, by default that of `source`. Raises FileExistsError if `target` exists.
    """
    target.mkdir(parents=True)
    for name in _files(source):
        there = target / name
        there.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source / name, there)
    share_compiled(source, target)
    values = yaml.safe_load((target / "params.yaml").read_text())
    (target / "params.yaml").write_text(yaml.safe_dump(overridden(values, params), sort_keys=False))
    folder = (cache or source / ".dvc" / "cache").resolve()
    (target / ".dvc" / "config.local").write_text(f"[core]\n    no_scm = true\n[cache]\n    dir = {folder}\n")


def share_compiled(source: Path, target: Path) -> None:
    """Copy what Python and Numba have compiled in `source` to the same folders of `target`.

    Either compares it with the code before it is used. Compiling all anew takes a workspace about a minute.
    """
    for folder in sorted({file.parent.relative_to(target) for file in target.rglob("*.py")}):
        compiled = source / folder / "__pycache__"
        if compiled.is_dir():
            shutil.copytree(compiled, target / folder / "__pycache__", dirs_exist_ok=True)


def overridden(values: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`values` with some replaced whole, named by dotted paths as in `dvc exp run -S`.

    >>> overridden({"run": {"seed": 7, "workers": 2}}, {"run.seed": 8})
    {'run': {'seed': 8, 'workers': 2}}

    Raises KeyError for a name that `values` does not have.
    """
    result = copy.deepcopy(dict(values))
    for name, value in over.items():
        *sections, last = name.split(".")
        place: Any = result
        for word in sections:
            place = place[word]
        if last not in place:
            raise KeyError(f"params.yaml has no {name!r} to replace")
        place[last] = value
    return result


def _files(source: Path) -> list[str]:
    """Tracked files, and new ones that nothing ignores; those deleted but still tracked are left out."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=source, capture_output=True, text=True, timeout=60, check=True,
    ).stdout  # fmt: skip
    return [name for name in sorted(set(listed.split("\0"))) if name and (source / name).is_file()]
