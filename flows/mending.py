"""Repairs DVC's own files after a run was killed, before DVC reads them.

DVC writes dvc.lock in place, so a kill may leave half of it. The committed file replaces it, or none does. No result is lost:
DVC's run cache is written first and restores every stage whose inputs are the same. The damaged file is moved to a folder.
"""

import json
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml
from dvc.rwlock import SCHEMA as LOCK_SCHEMA
from dvc.schema import COMPILED_LOCKFILE_SCHEMA
from voluptuous import Invalid

ASIDE = Path(".drivegen/damaged")
"""Where files that could not be read are kept, below the workspace."""


def mend(root: Path, tmp: Path) -> Iterator[str]:
    """Restore what is broken of the workspace `root`, whose folder for DVC's own locks is `tmp`: a sentence for each.

    To be called by who holds DVC's lock of the workspace, as who writes these files does.
    """
    for name in ("dvc.lock", "stages/dvc.lock"):
        if (root / name).is_file() and not is_whole((root / name).read_bytes()):
            yield f"{name} was cut off or broken, as by a kill while DVC wrote it: {_restored(root, name)}"
    if (tmp / "rwlock").is_file() and (sentence := _mended_lock(tmp / "rwlock", root)):
        yield sentence


def is_whole(raw: bytes) -> bool:
    """Whether DVC could have written this dvc.lock, to its last line."""
    try:
        COMPILED_LOCKFILE_SCHEMA(yaml.load(raw, yaml.CSafeLoader))
    except (yaml.YAMLError, UnicodeDecodeError, Invalid):
        return False
    return raw.endswith(b"\n")


def _restored(root: Path, name: str) -> str:
    aside = _set_aside(root / name, root)
    done = subprocess.run(["git", "show", f"HEAD:./{name}"], cwd=root, capture_output=True, timeout=60, check=False)
    if done.returncode or not is_whole(done.stdout):
        return f"it is made anew (what was there: {aside})"
    write_whole(root / name, done.stdout)
    return f"the committed one takes its place (what was there: {aside})"


def _mended_lock(file: Path, root: Path) -> str:
    """Remove a broken list of who reads and writes what, and of a sound one whoever runs no more; what was done, if anything."""
    try:
        held = LOCK_SCHEMA(json.loads(file.read_bytes()))
    except (ValueError, Invalid):
        aside = _set_aside(file, root)
        return f"{file.name}, DVC's list of files in use, was broken and is begun anew (what was there: {aside})"
    alive = {
        "read": {path: left for path, infos in held["read"].items() if (left := [info for info in infos if _runs(info)])},
        "write": {path: info for path, info in held["write"].items() if _runs(info)},
    }
    if alive == held:
        return ""
    write_whole(file, json.dumps(alive).encode())
    return "files that a run which was killed had in use are free again"


def _runs(info: dict[str, Any]) -> bool:
    """Whether the process that holds something still runs, and is not another one that was given its number since."""
    try:
        words = Path(f"/proc/{info['pid']}/cmdline").read_text(errors="replace").strip("\0").replace("\0", " ")
    except OSError:
        return False
    return words.endswith(" ".join(info["cmd"].split(" ")[1:]))  # its first word is the program, named in another way


def _set_aside(file: Path, root: Path) -> Path:
    """Move a file away; returns its new place, below the workspace."""
    aside = ASIDE / file.name
    (root / aside).parent.mkdir(parents=True, exist_ok=True)
    file.replace(root / aside)
    return aside


def write_whole(file: Path, content: bytes) -> None:
    """Write a file whole or not at all."""
    temporary = file.with_name(f".{file.name}.{os.getpid()}.part")
    temporary.write_bytes(content)
    temporary.replace(file)
