"""Descriptions with what they ask for, by which readers of words are judged.

A line of a suite's file is {"group", "text", "expect", "facts", "traffic"}. `group`: plain, long, or refuse (nothing may be
drawn). `expect`: names of `expect.py` and values. `facts`: what its author meant, in words. `traffic`: what of traffic is asked
for, as {"cars", "trucks", "buses", "density", "does"}. own.jsonl was at hand while the phrase table was written, fresh.jsonl was
written by three authors who knew the help text alone; four of their expectations that do not follow from the words are left out
(a motorway's carriageways are one-way edges; an oncoming car beside twelve cars).
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from drivegen.core import safe_json
from drivegen.core.errors import UnusableInput
from drivegen.maps.structure import Structure
from drivegen.maps.suite.expect import lacking

OWN, FRESH, OUTSIDE = "own", "fresh", "outside"
REFUSE = "refuse"
_LONGEST_CHECK = 120.0

Judge = Callable[[str, dict[str, Any]], list[str]]
"""Says of a text what it does not ask for of the traffic that is expected; readers of roads alone have none."""


@dataclass(frozen=True)
class Case:
    """One description: its suite and group, what its network must have (None: nothing may be drawn), and its traffic.

    `checker` is a program that judges the network instead, as `python CHECKER NETWORK EXPECT` (exit code 0: as asked).
    """

    suite: str
    group: str
    text: str
    expect: dict[str, Any] | None
    traffic: dict[str, Any] | None = None
    checker: Path | None = None

    def wrong(self, network: bytes, structure: Structure) -> list[str]:
        """What the network lacks of what was asked, as sentences; none where it is as asked."""
        if self.checker is not None:
            return _judged(self.checker, network, self.expect or {})
        return lacking(self.expect or {}, structure)


def own_cases() -> list[Case]:
    """The descriptions that ship with the package."""
    return [case for suite in (OWN, FRESH) for case in _read(suite)]


def _read(suite: str) -> list[Case]:
    source = files("drivegen.maps.suite") / f"{suite}.jsonl"
    lines = source.read_text(encoding="utf-8").splitlines() if source.is_file() else []
    rows = [json.loads(line) for line in lines if line.strip()]
    return [
        Case(suite, row["group"], row["text"], None if row["group"] == REFUSE else row.get("expect") or {}, row.get("traffic"))
        for row in rows
    ]


def outside_cases(folder: Path) -> list[Case]:
    """Those of a folder that holds `map_prompts.jsonl` (lines of "id", "prompt", "expect") and its judge `check_map.py`."""
    prompts, checker = folder / "map_prompts.jsonl", folder / "check_map.py"
    if not (prompts.is_file() and checker.is_file()):
        raise UnusableInput(f"{folder} must hold map_prompts.jsonl and check_map.py")
    try:
        rows = [safe_json.parse(line, prompts) for line in prompts.read_bytes().splitlines() if line.strip()]
        return [Case(OUTSIDE, "plain", row["prompt"], row["expect"], checker=checker.resolve()) for row in rows]
    except (ValueError, KeyError, TypeError) as error:
        raise UnusableInput(f"{prompts} is no file of descriptions: {error}", reason="not-json") from None


def _judged(checker: Path, network: bytes, expect: dict[str, Any]) -> list[str]:
    with tempfile.TemporaryDirectory(prefix="drivegen-checker-") as folder:
        file = Path(folder) / "map.net.xml"
        file.write_bytes(network)
        command = [sys.executable, str(checker), str(file), json.dumps(expect)]
        try:
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=_LONGEST_CHECK, check=False)
        except subprocess.TimeoutExpired:
            return ["the checker did not end in time"]
    if done.returncode == 0:
        return []
    return done.stdout.splitlines() or ["the checker failed"]
