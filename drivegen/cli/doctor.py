"""`drivegen doctor`: what is installed, what is there, what is missing, and what to do about it."""

import importlib.metadata
import shutil
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import yaml
from packaging.requirements import Requirement
from rich.console import Console
from rich.markup import escape
from typer import Exit, Option

from drivegen.core.errors import DriveGenError, UnusableInput
from drivegen.core.seal import expect_seal, has_seal
from drivegen.sumo.netconvert import plain_to_net
from drivegen.sumo.plain import Edge, Node, PlainNetwork

ROOM_WANTED = 5e9
"""Free disk space below which a run may fail [bytes]: 3 GB of packages, then the cache and the data."""

_REINSTALL = "rm .venv/.installed && make lint"
_LOOP = "import libsumo; libsumo.start(['sumo', '-n', 'net.net.xml', '--no-step-log', 'true']); libsumo.simulationStep()"
_MADE_BY_RUN = (
    ("scenarios", "data/scenarios"),
    ("trained planner", "data/models/planners"),
    ("trained goal selector", "data/models/selector"),
    ("limits of the legal checker", "data/models/limits.json"),
    ("report", "reports/index.html"),
)


@dataclass(frozen=True)
class Finding:
    """One line of the doctor's; `ok` is None where something is good to know and nothing is wrong."""

    what: str
    ok: bool | None
    found: str
    remedy: str = ""


def command(
    lm: Annotated[bool, Option("--lm", help="Also try the configured language models with one tiny call each.")] = False,
) -> None:
    """Check versions, SUMO, GPU, data and weights, and say what to do. Exits 1 if something needed is missing."""
    findings = [python(), *versions(), *sumo(), gpu(), *places(Path()), *damage(Path()), disk(Path()), loopback()]
    findings += language_models() if lm else []
    console = Console(soft_wrap=True, highlight=False)
    width = max(len(finding.what) for finding in findings) + 2
    for finding in findings:
        mark = {True: "[green]ok[/]     ", False: "[red]MISSING[/]", None: "-      "}[finding.ok]
        remedy = f"  [dim]->[/] {finding.remedy}" if finding.remedy else ""
        console.print(f"{mark}  {finding.what:{width}}{escape(finding.found)}{remedy}")
    if any(finding.ok is False for finding in findings):
        raise Exit(1)


def python() -> Finding:
    """The interpreter's own version."""
    version = ".".join(map(str, sys.version_info[:3]))
    good = (3, 11) <= sys.version_info[:2] < (3, 13)
    return Finding("python", good, version, "" if good else "make PYTHON=python3.12 run")


def versions() -> Iterator[Finding]:
    """Every pinned dependency against what is installed; Prefect's server dies with a FastAPI that pip accepts."""
    wrong = 0
    requirements = [Requirement(line) for line in importlib.metadata.requires("drivegen") or []]
    requirements = [r for r in requirements if r.marker is None or r.marker.evaluate()]
    for requirement in requirements:
        try:
            version = importlib.metadata.version(requirement.name)
        except importlib.metadata.PackageNotFoundError:
            version = "not installed"
        if version == "not installed" or not requirement.specifier.contains(version, prereleases=True):
            wrong += 1
            yield Finding(requirement.name, False, version, f"wanted {requirement.specifier}: {_REINSTALL}")
    if not wrong:
        yield Finding("packages", True, f"all {len(requirements)} as pinned")


def sumo() -> Iterator[Finding]:
    """netconvert makes a network of one road, and libsumo steps on it in a process of its own, where it may crash."""
    nodes = [Node("a", 0.0, 0.0), Node("b", 100.0, 0.0)]
    try:
        net = plain_to_net(PlainNetwork(nodes=nodes, edges=[Edge("ab", "a", "b", 1, 13.9)]))
    except DriveGenError as error:
        yield Finding("netconvert", False, str(error), _REINSTALL)
        return
    yield Finding("netconvert", True, "makes a network")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "net.net.xml").write_bytes(net)
        words = [sys.executable, "-W", "ignore", "-c", _LOOP]
        try:
            done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
        except subprocess.TimeoutExpired:
            yield Finding("libsumo", False, "has not made a step in a minute", _REINSTALL)
            return
    last = (done.stderr.strip().splitlines() or ["no words"])[-1]
    good = done.returncode == 0
    yield Finding("libsumo", good, "steps" if good else f"exit {done.returncode}: {last}", "" if good else _REINSTALL)


def gpu() -> Finding:
    """One is used where there is one; nothing needs it."""
    import torch

    if torch.cuda.is_available():
        return Finding("GPU", True, f"{torch.cuda.get_device_name()}, CUDA {torch.version.cuda}")
    return Finding("GPU", None, f"none (torch {torch.__version__})", "not needed; the full planner trains faster with one")


def places(root: Path) -> Iterator[Finding]:
    """What `make run` leaves behind, below the current folder."""
    for what, name in _MADE_BY_RUN:
        there = (root / name).exists()
        yield Finding(what, there or None, name if there else f"no {name} here", "" if there else "make run")


def damage(root: Path) -> Iterator[Finding]:
    """Files of the pipeline that a kill cut off or that changed since they were written, below the current folder."""
    for name in ("dvc.lock", "stages/dvc.lock"):
        if (root / name).is_file() and not _is_lock((root / name).read_bytes()):
            yield Finding(name, False, "cut off or broken", "make run restores it, from the commit where there is one")
    files = [file for pattern in ("*.parquet", "*.safetensors") for file in sorted((root / "data").rglob(pattern))]
    whole = 0
    for file in files:
        try:
            raw = file.read_bytes()
        except OSError as error:  # a folder of that name, or a link whose file has left DVC's cache
            yield Finding(
                "checksums", False, f"{file} cannot be read: {error.strerror}", "remove it, then dvc checkout or make run"
            )
            continue
        if not has_seal(raw):  # tables of results have none
            continue
        try:
            expect_seal(raw, file, "remove it, then make run")
            whole += 1
        except UnusableInput as error:
            yield Finding("checksums", False, *str(error).split(": ", 1))
    if whole:
        yield Finding("checksums", True, f"{whole} shards and weights are as they were written")


def _is_lock(raw: bytes) -> bool:
    """Whether DVC may have written it to its end. Cut off behind a name it is YAML still, but DVC gives each name a value."""
    try:
        yaml.load(raw, yaml.CSafeLoader)
    except (yaml.YAMLError, UnicodeDecodeError):
        return False
    return raw.endswith(b"\n") and not raw.endswith(b":\n")


def disk(root: Path) -> Finding:
    """Free space where the data will be."""
    free = shutil.disk_usage(root.resolve()).free
    return Finding("disk", free > ROOM_WANTED, f"{free / 1e9:.0f} GB free", "" if free > ROOM_WANTED else "make room")


def loopback() -> Finding:
    """Flows start a Prefect server on 127.0.0.1."""
    try:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
    except OSError as error:
        return Finding("127.0.0.1", False, str(error.strerror), "allow local sockets, or use `dvc repro` without flows")
    return Finding("127.0.0.1", True, "a free port for Prefect's server")


def language_models() -> Iterator[Finding]:
    """One tiny call of each role's model; roles that share one share the call, and its failure."""
    from drivegen.cli._lm import role, tiny_call
    from drivegen.lm.settings import ROLES

    answers: dict[tuple[str, str, str, str, str], tuple[bool, str]] = {}
    for name in ROLES:
        what, remedy = f"language model for {name}", f"see lm.{name} in params.yaml"
        try:
            settings = role(name, None, None)
        except DriveGenError as error:
            yield Finding(what, False, str(error), remedy)
            continue
        if settings.backend == "offline":
            yield Finding(what, None, "none configured", f"not needed; {remedy}")
            continue
        asked = (settings.backend, settings.model, settings.base_url, settings.key, settings.output)
        if asked not in answers:
            try:
                answers[asked] = True, f"{settings.model} {tiny_call(settings)}"
            except DriveGenError as error:
                answers[asked] = False, str(error)
        good, found = answers[asked]
        yield Finding(what, good, found, "" if good else remedy)
