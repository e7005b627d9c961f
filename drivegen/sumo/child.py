"""Run one of our programs that load libsumo, in a process of its own.

libsumo crashes its process on malformed networks, keeps one simulation per process and holds the interpreter's lock. The
program is run by path, gets the name of the folder with its input, and no more of the environment than SUMO
needs. It limits its own processor time and memory; its last error message becomes one sentence.
"""

import os
import subprocess
import sys
from pathlib import Path

from drivegen.core.errors import UnusableInput

_PASSED_ON = ("PATH", "HOME", "LD_LIBRARY_PATH", "SUMO_HOME")
_LONGEST_MESSAGE = 300


class SimulationFailed(UnusableInput):
    """SUMO refused the input, crashed or took too long; `reason` is sumo-refused, sumo-crashed, timeout or no-traffic."""


def start(program: Path, folder: Path, words: tuple[str, ...], patience: float) -> "subprocess.CompletedProcess[bytes]":
    """Run `program` with `folder` and `words` as its arguments; raises subprocess.TimeoutExpired after `patience` [s]."""
    command = [sys.executable, "-P", str(program), str(folder), *words]
    environment = {key: os.environ[key] for key in _PASSED_ON if key in os.environ}
    return subprocess.run(command, cwd=folder, env=environment, timeout=patience, capture_output=True, check=False)


def simulate(program: Path, folder: Path, time_limit: float) -> None:
    """Run `program` on `folder` to its end, for at most `time_limit` [s] and half as much again of waiting.

    Raises SimulationFailed whatever SUMO does.
    """
    try:
        done = start(program, folder, (), 1.5 * time_limit)
    except subprocess.TimeoutExpired:
        raise SimulationFailed(f"SUMO was stopped after {1.5 * time_limit:.0f} s", reason="timeout") from None
    if done.returncode < 0:
        raise SimulationFailed(f"SUMO crashed (signal {-done.returncode})", reason="sumo-crashed")
    if done.returncode:
        cause = _cause(done.stderr.decode("utf-8", "replace")) or f"exit code {done.returncode}"
        raise SimulationFailed(f"SUMO refuses the run: {cause[:_LONGEST_MESSAGE]}", reason="sumo-refused")


def _cause(text: str) -> str:
    """SUMO's first line about an error, or, where it printed none, the exception at the end."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return next((line for line in lines if "Error" in line), lines[-1] if lines else "")
