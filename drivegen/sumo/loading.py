"""Does SUMO itself load a network? netconvert's word is not enough: libsumo refuses, and dies of, some of what it makes."""

import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from drivegen.sumo import child, loading_process

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
    (folder / "loaded").unlink(missing_ok=True)
    with suppress(subprocess.TimeoutExpired):  # what it had loaded until then stands
        child.start(_PROGRAM, folder, (str(first), str(count), str(seconds)), 1.5 * seconds)
    listing = folder / "loaded"
    return [int(line) for line in listing.read_text().split()] if listing.exists() else []
