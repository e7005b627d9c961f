"""Mutated words, specifications, edits and files: an answer or one of our own errors, never a traceback, a hang or a stray file.

`DRIVEGEN_FUZZ` is the number of mutants of each sort, or a small multiple (`make fuzz` takes thousands).
"""

import contextlib
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from drivegen.core import seeds
from drivegen.core.errors import DriveGenError, UnusableInput
from drivegen.layouts.spec import MapSpec
from drivegen.maps.build import build_spec
from drivegen.maps.imports import import_map
from drivegen.maps.suite.cases import own_cases
from drivegen.words.edits import edited
from drivegen.words.read import read
from tests.maps.mutants import COUNT, WATCH, at_most, mutated_bytes, mutated_spec, mutated_text
from tests.refusals import assert_one_sentence

SUITE = [case.text for case in own_cases()]


def specs() -> list[dict[str, Any]]:
    texts = [
        "a signalised crossroads with left-turn lanes",
        "a roundabout of five roads",
        "two T-junctions 100 m apart",
        "a hairpin",
    ]
    texts += ["a motorway with an on-ramp and an off-ramp", "a cul-de-sac", "a 2 by 2 grid", "a motorway that forks into two"]
    texts += ["a trumpet interchange"]
    fork = {"kind": "fork", "length": 400, "stem": 600}
    pockets = {"kind": "corridor", "junctions": [{"position": 300, "left_turn_lanes": 1, "pocket": 40}]}
    arcs = {"kind": "corridor", "alignment": {"shape": "s_curve", "arcs": [[90, 50], [-70, 75]]}}
    bent = {
        "kind": "corridor",
        "alignment": {"shape": "curve", "length": 500},
        "junctions": [{"position": 250, "sides": ["right"]}],
    }
    loops = {"kind": "quadrant_interchange", "south_west": "loop", "north_east": "none", "loop_radius": 30}
    understood = [road for text in texts if (road := read(text, 7).road) is not None]
    typed = [MapSpec.model_validate({"road": road}) for road in (fork, pockets, arcs, bent, loops)]
    return [spec.model_dump(mode="json") for spec in (*understood, *typed)]


@pytest.fixture
def strayed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The test works in an empty folder, leaves it empty, and no file outside it is written or read."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.chdir(tmp_path)
    read("a road", 7)  # reads the table
    with WATCH.over(tmp_path) as found:
        yield found
    assert found == []
    assert list(tmp_path.iterdir()) == []


def test_the_watch_sees_who_strays(tmp_path: Path) -> None:
    (tmp_path / "work").mkdir()
    with WATCH.over(tmp_path / "work") as found:
        (tmp_path / "work" / "a").write_text("fine")
        (tmp_path / "b").write_text("strayed")
        Path("/etc/passwd").read_text()
    assert found == [str(tmp_path / "b"), "/etc/passwd"]


def test_what_never_ends_fails() -> None:
    with pytest.raises(AssertionError, match="longer than 1 s"):
        forever()


def forever() -> None:
    with at_most(1):
        while True:
            pass


def test_mutated_words_are_understood_or_refused(strayed: list[str]) -> None:
    rng = seeds.rng(7, "fuzz", "words")
    answered = 0
    for i in range(COUNT * (10 if COUNT > 100 else 2)):  # reading one takes up to a second
        text = mutated_text(rng, SUITE[i % len(SUITE)])
        with at_most(), contextlib.suppress(UnusableInput):
            answered += read(text, 7).road is not None
    assert answered >= COUNT // 5


def test_mutated_specifications_are_built_or_refused(strayed: list[str]) -> None:
    rng = seeds.rng(7, "fuzz", "specifications")
    bases = specs()
    built = 0
    for i in range(COUNT):
        with at_most(), contextlib.suppress(ValidationError, DriveGenError):
            spec = MapSpec.model_validate(mutated_spec(rng, bases[i % len(bases)]))
            built += len(build_spec(spec, {}).road_map) > 0
    assert built > 0


def test_mutated_edits_are_applied_or_refused(strayed: list[str]) -> None:
    rng = seeds.rng(7, "fuzz", "edits")
    edits = ["add a lane", "remove the signals", "make it a roundabout", "move the ramp 100 m downstream", "limit 30 km/h"]
    bases = [MapSpec.model_validate(fields) for fields in specs()]
    applied = 0
    for i in range(5 * COUNT):
        edit = mutated_text(rng, edits[i % len(edits)])
        with at_most(), contextlib.suppress(DriveGenError):
            after = edited(bases[i % len(bases)], edit)
            assert MapSpec.model_validate(after.model_dump()) == after
            applied += 1
    assert 0 < applied < 5 * COUNT


def test_mutated_files_are_imported_or_refused_and_leave_nothing_behind(strayed: list[str]) -> None:
    rng = seeds.rng(7, "fuzz", "files")
    network = build_spec(MapSpec.model_validate(specs()[0]), {}).network
    whole, read = len(import_map(network, "whole.net.xml").road_map), 0
    for _ in range(2 * COUNT):
        try:
            with at_most():
                found = import_map(mutated_bytes(rng, network), "mutant.net.xml")
        except UnusableInput as refusal:
            assert_one_sentence(refusal, "mutant.net.xml")
            continue
        found.road_map.validate()
        assert 0 < len(found.road_map) <= whole
        read += 1
    assert 0 < read < 2 * COUNT
