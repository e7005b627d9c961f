"""Roads from words: our own suite of descriptions, each with what the network must have or why it must be refused."""

import importlib.util
import json
import os
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from drivegen.errors import UnusableInput
from drivegen.maps.build import build_map
from drivegen.maps.compile import compile_map
from drivegen.maps.structure import Structure
from drivegen.maps.writers.offline import Plugin

SUITE = [json.loads(line) for line in (files("drivegen.maps.suite") / "own.jsonl").read_text().splitlines()]
DRAWN = [row for row in SUITE if "expect" in row]
REFUSED = [row for row in SUITE if "refused" in row]
TOLERANT = {"speed_kmh", "length", "turn"}


def seen(found: Structure, name: str) -> Any:
    value = found.speed * 3.6 if name == "speed_kmh" else getattr(found, name)
    return list(value) if isinstance(value, tuple) else value


@pytest.mark.parametrize("row", DRAWN, ids=lambda row: row["text"][:60])
def test_a_description_becomes_the_road_that_it_describes(row: dict[str, Any]) -> None:
    built = build_map(row["text"], seed=7)
    assert built.account["failed"] == []
    for name, want in row["expect"].items():
        got = seen(built.structure, name)
        assert got == (pytest.approx(want, rel=0.12, abs=1.0) if name in TOLERANT else want), name
    assert set(row.get("ignored", [])) <= set(built.account["ignored"])


@pytest.mark.parametrize("row", REFUSED, ids=lambda row: repr(row["text"][:60]))
def test_what_cannot_be_drawn_is_refused_in_one_sentence(row: dict[str, Any]) -> None:
    with pytest.raises(UnusableInput) as refusal:
        Plugin().write(row["text"], seed=7)
    assert row["refused"] in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_the_suite_is_large_and_names_every_kind_three_times() -> None:
    kinds = [row["kind"] for row in DRAWN]
    roads = {"crossing", "t", "y", "staggered", "roundabout", "row", "grid", "straight", "curve", "s_curve", "hairpin"}
    roads |= {"highway", "on_ramp", "off_ramp", "weaving", "lane_drop", "lane_gain", "fork", "cul_de_sac", "side_streets"}
    assert len(SUITE) >= 60
    assert all(kinds.count(kind) >= 3 for kind in roads)


def test_the_same_words_and_seed_give_the_same_bytes_and_another_seed_other_lengths() -> None:
    text = "a T-junction with traffic lights"
    assert build_map(text, 7).network == build_map(text, 7).network
    assert Plugin().write(text, 7).spec != Plugin().write(text, 8).spec


def test_words_of_vehicles_are_not_listed_as_ignored_when_their_reader_took_them() -> None:
    text = "a roundabout with four arms and a bus"
    assert "bus" in Plugin().write(text, 7).ignored
    assert "bus" not in Plugin().write(text, 7, vehicle_words={"bus"}).ignored


def test_a_number_of_roads_that_no_rule_took_is_not_passed_over() -> None:
    with pytest.raises(UnusableInput, match="9 branches"):
        Plugin().write("a signalised crossing with two lanes per direction of 4 arms and 9 branches", 7)


def _benchmark() -> Path:
    data = os.environ.get("DRIVEGEN_REAL_DATA")
    shared = Path(data).parent if data else Path(__file__).parents[3] / "shared"
    return shared / "benchmarks"


def test_the_shared_benchmark_passes(tmp_path: Path) -> None:
    prompts, checker = _benchmark() / "map_prompts.jsonl", _benchmark() / "check_map.py"
    if not (prompts.exists() and checker.exists()):
        pytest.skip("the shared map benchmark is not here")
    spec = importlib.util.spec_from_file_location("check_map", checker)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    failed = {}
    for row in map(json.loads, prompts.read_text().splitlines()):
        network = tmp_path / f"{row['id']}.net.xml"
        network.write_bytes(compile_map(Plugin().write(row["prompt"], 7).spec))
        if wrong := module.check(str(network), row["expect"]):
            failed[row["prompt"]] = wrong
    assert failed == {}
