"""Mutated words, specifications and files: an answer or one of our own errors, never a traceback, a hang or a stray file.

`DRIVEGEN_FUZZ` is the number of mutants of each sort (the nightly run takes thousands).
"""

import contextlib
import copy
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from drivegen import seeds
from drivegen.errors import DriveGenError
from drivegen.maps.build import build_spec
from drivegen.maps.imports import import_map
from drivegen.maps.refine import refine
from drivegen.maps.spec import MapSpec
from drivegen.maps.suite.cases import own_cases
from drivegen.maps.writers.offline import Plugin

COUNT = int(os.environ.get("DRIVEGEN_FUZZ", "40"))
SUITE = [case.text for case in own_cases()]
NASTY = [0, -1, 1e9, float("nan"), float("inf"), "", "x" * 5000, None, [], {}, True, "../../etc/passwd", "&x;", "\u202e", 8, 45.0]
WORDS = ["not", "no", "without", "2", "nine hundred", "lanes", "by", "0", "-3", "1e9", "km/h", "roundabout", "crossing", "ramp"]
WORDS += [",", ".", "(", "then", "and", "of the", "to", "one-way", "交叉口", "Kreuzung"]
BYTES = [b"<", b">", b'"', b"", b"nan", b"-1", b"1e400", b"<!DOCTYPE x>", b"\x00", b"</net>", b"from", b"lane", b" " * 50]


def mutated_text(rng: np.random.Generator, text: str) -> str:
    words = text.split() or [""]
    for _ in range(rng.integers(1, 5)):
        place = int(rng.integers(len(words) + 1))
        if rng.random() < 0.5:
            words.insert(place, str(rng.choice(WORDS)))
        elif len(words) > 1:
            words.pop(min(place, len(words) - 1))
    return " ".join(words)


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [p for key, item in items for p in [(*path, key), *places(item, (*path, key))]]


def mutated_spec(rng: np.random.Generator, fields: dict[str, Any]) -> dict[str, Any]:
    fields = copy.deepcopy(fields)
    for _ in range(rng.integers(1, 3)):
        *way, last = (found := places(fields))[int(rng.integers(len(found)))]
        parent = fields
        for key in way:
            parent = parent[key]
        number = isinstance(parent[last], int | float) and rng.random() < 0.7
        scale = float(rng.choice([0.5, 0.9, 1.1, 2.0, -1.0]))
        parent[last] = type(parent[last])(parent[last] * scale) if number else NASTY[int(rng.integers(len(NASTY)))]
    return fields


def mutated_bytes(rng: np.random.Generator, raw: bytes) -> bytes:
    for _ in range(rng.integers(1, 4)):
        a = int(rng.integers(len(raw)))
        b = a + int(rng.choice([0, 1, 3, 40]))
        raw = raw[:a] + BYTES[int(rng.integers(len(BYTES)))] + raw[b:]
    return raw


def specs() -> list[dict[str, Any]]:
    texts = ["a signalised crossroads with turn lanes", "a roundabout of five roads", "two T-junctions 100 m apart", "a hairpin"]
    texts += ["a motorway with an on-ramp and an exit", "a cul-de-sac", "a 2x2 grid", "a motorway that forks into two"]
    return [Plugin().write(text, 7).spec.model_dump(mode="json") for text in texts]


def test_mutated_words_are_understood_or_refused() -> None:
    rng = seeds.rng(7, "fuzz", "words")
    answered = 0
    for i in range(10 * COUNT):
        text = mutated_text(rng, SUITE[i % len(SUITE)])
        with contextlib.suppress(DriveGenError):
            answered += isinstance(Plugin().write(text, 7).spec, MapSpec)
    assert answered > COUNT


def test_mutated_specifications_are_built_or_refused() -> None:
    rng = seeds.rng(7, "fuzz", "specifications")
    bases = specs()
    built = 0
    for i in range(COUNT):
        with contextlib.suppress(ValidationError, DriveGenError):
            spec = MapSpec.model_validate(mutated_spec(rng, bases[i % len(bases)]))
            built += len(build_spec(spec, {}).road_map) > 0
    assert built > 0


def test_mutated_edits_are_applied_or_refused() -> None:
    rng = seeds.rng(7, "fuzz", "edits")
    edits = ["add a lane", "remove the signals", "make it a roundabout", "move the ramp 100 m downstream", "limit 30 km/h"]
    bases = [MapSpec.model_validate(fields) for fields in specs()]
    for i in range(5 * COUNT):
        edit = mutated_text(rng, edits[i % len(edits)])
        with contextlib.suppress(DriveGenError):
            assert isinstance(refine(bases[i % len(bases)], edit)[0], MapSpec)


@pytest.fixture
def nothing_else_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_mutated_files_are_imported_or_refused_and_leave_nothing_behind(nothing_else_is_written: Path) -> None:
    rng = seeds.rng(7, "fuzz", "files")
    network = build_spec(MapSpec.model_validate(specs()[0]), {}).network
    for _ in range(2 * COUNT):
        with contextlib.suppress(DriveGenError):
            import_map(mutated_bytes(rng, network), "mutant.net.xml").road_map.validate()
    assert list(nothing_else_is_written.iterdir()) == []
