"""Does SUMO itself load a network? netconvert's word is not enough: libsumo refuses, and dies of, some of what it makes."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from drivegen.sumo import loading_process

_PROGRAM = Path(loading_process.__file__)  # run, never called; imported so that whoever follows imports finds it
_SECONDS = 20
"""Processor time for the process, and as much again for every network."""


def load_all(networks: Sequence[bytes]) -> list[bool]:
    """Whether each network is loaded and stepped once by libsumo, in a child process.

    One process serves all; where a network ends it (an error, a crash, a hang), the next process goes on behind that one.
    """
    loads = [False] * len(networks)
    with tempfile.TemporaryDirectory(prefix="drivegen-sumo-") as name:
        folder = Path(name)
        for i, network in enumerate(networks):
            (folder / f"{i}.net.xml").write_bytes(network)
        first = 0
        while first < len(networks):
            for i in (done := _loaded(folder, first, len(networks))):
                loads[i] = True
            first += len(done) + 1
    return loads


def _loaded(folder: Path, first: int, count: int) -> list[int]:
    """The networks that one process loads, from `first` on, until one ends it."""
    seconds = _SECONDS * (1 + count - first)
    command = [sys.executable, "-P", str(_PROGRAM), str(folder), str(first), str(count), str(seconds)]
    environment = {key: os.environ[key] for key in ("PATH", "HOME", "LD_LIBRARY_PATH", "SUMO_HOME") if key in os.environ}
    (folder / "loaded").unlink(missing_ok=True)
    with suppress(subprocess.TimeoutExpired):  # what it had loaded until then stands
        subprocess.run(command, cwd=folder, env=environment, timeout=1.5 * seconds, capture_output=True, check=False)
    told = folder / "loaded"
    return [int(line) for line in told.read_text().split()] if told.exists() else []
