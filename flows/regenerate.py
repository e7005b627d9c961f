"""A new version of the generated data set: the same models, new seeds, on a schedule if wanted (`prefect.yaml`).

The stages that make new scenarios run in a workspace of their own with another `run.seed`; what they read (models,
assets) comes unchanged from this workspace's dvc.lock. Their outputs are published together in data/versions/VERSION,
with a manifest that names the seed, the inputs and the SHA-256 of every file; a version is never overwritten.
"""

import datetime
import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

from prefect import flow
from prefect.artifacts import create_table_artifact

from flows import FlowFailed, pipeline, workspace
from flows.bring_up import bring_up, by_a_sentence

STAGES = ("maps", "place", "ship")
"""Those that make new scenarios, in running order."""

PUBLISHED = Path("data/versions")
_ROOM = Path(".drivegen/regenerate")


@flow(name="regenerate")
@by_a_sentence
def regenerate(version: str | None = None, seed: int | None = None) -> str:
    """Generate and publish one version; returns its folder. By default it is named by the day and seeded by its name."""
    version = version or datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
    seed = seed if seed is not None else seed_of(version)
    if Path(version).name != version or version == "..":  # its workspace, of the same name, is deleted first
        raise FlowFailed(f"{version!r} is no name for a folder: give one without /")
    target, room = PUBLISHED / version, _ROOM / version
    with workspace.alone(f"regenerate-{version}"):
        if target.exists():
            raise FlowFailed(f"{target} exists and versions are never overwritten: give another name")
        workspace.renew(Path(), room, {"run.seed": seed})
        prepare(room)
        try:
            for stage in STAGES:
                bring_up(stage, room)
        finally:
            workspace.bring_home(room, Path())
        manifest = publish(room, target, version, seed)
        shutil.rmtree(room)
    files = [{"file": name, "sha256": digest} for name, digest in manifest["files"].items()]
    create_table_artifact(files, key="version", description=f"{target}, seed {seed}")
    return str(target)


def prepare(room: Path) -> None:
    """Fetch from the cache what the generation stages read and do not make themselves."""
    outputs = {path for stage in STAGES for path in pipeline.outputs(stage, room)}
    needed = {path for stage in STAGES for path in pipeline.inputs(stage, room)} - outputs
    pipeline.checkout(sorted(needed), room)


def publish(room: Path, target: Path, version: str, seed: int) -> dict[str, Any]:
    """Move the outputs out of `room` and put the version in place as a whole; returns its manifest."""
    waiting = room / "published"
    for stage in STAGES:
        for path in pipeline.outputs(stage, room):
            there = waiting / path
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(room / path, there)
    shutil.copy2(room / "dvc.lock", waiting / "dvc.lock")
    files = {str(file.relative_to(waiting)): _sha256(file) for file in sorted(waiting.rglob("*")) if file.is_file()}
    manifest = {"version": version, "seed": seed, "stages": list(STAGES), "lineage": "dvc.lock", "files": files}
    (waiting / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n")
    target.parent.mkdir(parents=True, exist_ok=True)
    waiting.rename(target)
    return manifest


def seed_of(version: str) -> int:
    """The same seed for the same name, on every machine."""
    return int.from_bytes(hashlib.sha256(version.encode()).digest()[:4], "big") >> 1


def _sha256(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
