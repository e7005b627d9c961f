"""The descriptions: our own, those written by somebody who had not seen the rules, and a folder's from outside.

Part A of those held out was given to the rules' author after the first try, part B was not; C and D are in the words of
engineers, police reports, forums, patents and children, written before their failures were looked at; E to Q, S, U and V are by
authors who had not seen the rules: E to J, M and O were mended after the first try (two of I's repeat others and are left
out), K and L were not by their own failures, N and P were sealed until the rules stood still (b67cbe5) and mended after
their only first try. M to P are long, with three or four facts each; their expectations are the authors', unchanged, and
the first try of M and O is told of the rules before and after what is said began to be looked up in what is built. Q and S
are of plain requests, U and V of long ones with remarks on what the map is for; Q and U were given to the rules' author after
the first try, S and V were sealed and are told of the rules before and after Q and U were mended.
A line of the files is {"kind", "text"} with either "expect", names of `Structure` (or `speed_kmh`; with `_min` behind: at
least) and values, or "refused", words that the refusal must hold. Names of vehicles that a map writer must list as ignored
stand in "ignored".
"""

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

from drivegen.errors import UnusableInput
from drivegen.maps.structure import Structure

OWN, HELD_OUT, OUTSIDE = "own", "held out", "outside"
"""The suites: written beside the rules, written without having read them, and a folder's."""

_TOLERANT = {"speed_kmh", "length", "turn"}
_RELATIVE, _ABSOLUTE = 0.12, 1.0
_LONGEST_CHECK = 120.0


@dataclass(frozen=True)
class Case:
    """One description.

    Attributes:
        suite: where it comes from. kind: of road, or impossible, hostile, unknown, a language.
        expect: what the network must have; None where the description must be refused.
        refused: what the refusal must say. ignored: words that must be listed as ignored.
        checker: a program that judges the network instead, as `python CHECKER NETWORK EXPECT` (exit code 0: as asked).
    """

    suite: str
    kind: str
    text: str
    expect: dict[str, Any] | None
    refused: str = ""
    ignored: tuple[str, ...] = field(default=())
    checker: Path | None = None

    def wrong(self, network: bytes, found: Structure) -> list[str]:
        """What the network lacks of what was asked, as sentences; none where it is as asked. For cases that expect a road."""
        if self.checker is not None:
            return _judged(self.checker, network, self.expect or {})
        return [f"{n}: asked {w}, got {seen(found, n)}" for n, w in (self.expect or {}).items() if not _agrees(n, w, found)]


def own_cases() -> list[Case]:
    """The descriptions that ship with the package."""
    return [*_read(OWN, "own.jsonl"), *_read(HELD_OUT, "held_out.jsonl")]


def first_try() -> list[dict[str, Any]]:
    """How the offline rules fared with the held-out descriptions the first time they saw them, with date and revision."""
    source = files("drivegen.maps.suite") / "first_try.json"
    return list(json.loads(source.read_text(encoding="utf-8")))


def outside_cases(folder: Path) -> list[Case]:
    """Those of a folder that holds `map_prompts.jsonl` (lines of "id", "prompt", "expect") and its judge `check_map.py`."""
    prompts, checker = folder / "map_prompts.jsonl", folder / "check_map.py"
    if not (prompts.is_file() and checker.is_file()):
        raise UnusableInput(f"{folder} must hold map_prompts.jsonl and check_map.py")
    try:
        rows = [json.loads(line) for line in prompts.read_text().splitlines() if line.strip()]
        return [Case(OUTSIDE, "outside", row["prompt"], row["expect"], checker=checker.resolve()) for row in rows]
    except (ValueError, KeyError, TypeError) as error:
        raise UnusableInput(f"{prompts} is no file of descriptions: {error}", reason="not-json") from None


def seen(found: Structure, name: str) -> Any:
    """What a network has of what an expectation names."""
    name = name.removesuffix("_min")
    value = found.speed * 3.6 if name == "speed_kmh" else getattr(found, name)
    return list(value) if isinstance(value, tuple) else value


def _agrees(name: str, want: Any, found: Structure) -> bool:
    got = seen(found, name)
    if name.endswith("_min"):
        return bool(got >= want)
    return bool(abs(got - want) <= max(_ABSOLUTE, _RELATIVE * abs(want)) if name in _TOLERANT else got == want)


def _read(suite: str, name: str) -> list[Case]:
    source = files("drivegen.maps.suite") / name
    rows = [json.loads(line) for line in source.read_text(encoding="utf-8").splitlines()] if source.is_file() else []
    return [_case(suite, row) for row in rows]


def _case(suite: str, row: dict[str, Any]) -> Case:
    suite = f"{suite} {row['part']}" if row.get("held_out") else suite
    return Case(suite, row["kind"], row["text"], row.get("expect"), row.get("refused", ""), tuple(row.get("ignored", ())))


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
