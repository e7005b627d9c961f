"""The stage `survival` on a hand-made case, and its published table."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pytest

from drivegen.adversaries.shared.held import replays
from drivegen.core import plugins
from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario
from drivegen.corner_cases.survival import ATTENTION, Reacting
from drivegen.store.files import write_json
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from stages import publish_corner, survival
from stages._door import read_params, read_section
from tests.drivers.taught import PARAMS
from tests.scenes import drive, scenario, stack, straight_road
from tests.stages.crossing_cases import LINE, SHARD

WHO = [str(who) for who in Reacting if who != Reacting.NOBODY]
ACROSS = np.array([[35.0, -60.0], [35.0, 60.0]]) + LINE[0]


def crossed(speed: float) -> Scenario:
    """The target is on the other's way from 3.9 s on; the other there at 5.8 s, if at all."""
    return scenario(straight_road(), stack([drive(LINE, 20, 3, 101), drive(ACROSS, 0, speed, 101)]), "run0-0")


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """One scene, in which the case of one attack is that somebody drives across; the other attack found nothing."""
    root = tmp_path_factory.mktemp("survival")
    stands, comes = crossed(0.0), crossed(9.8)
    write_shard(root / "test" / SHARD, [stands])
    write_samples(root / "round" / SHARD, [Samples.without_goals("run0-0", "drivegen", stands.log[np.newaxis])])
    case = Samples.without_goals("run0-0", "random", comes.log[np.newaxis])
    write_samples(root / "attack/idm/random.legal.10/samples.parquet", [case])
    write_samples(root / "attack/idm/cat.legal.10/samples.parquet", [])
    return root


def params() -> survival.Params:
    slow = {**read_section("survival.drivers.idm", PARAMS), "acceleration": 0.01}  # it stays on the other's way for long
    few = {"attacks": ["random.legal.10", "cat.legal.10"], "drivers": {"idm": slow}, "draws": 20}
    return replace(read_params("survival", survival.Params, PARAMS), **few)


def run(made: Path, out: Path) -> list[dict[str, object]]:
    survival.main(params(), made / "test", made / "round", made / "attack", out / publish_corner.HELD)
    return orjson.loads((out / publish_corner.HELD).read_bytes())


def test_who_comes_across_stops_if_it_may_react_and_hits_if_it_is_deaf(made, tmp_path):
    rows = run(made, tmp_path)
    assert {(row["method"], row["driver"], row["n"]) for row in rows} == {("random", "idm", 1)}  # cat found nothing
    assert [(row["attention"], row["reacting"]) for row in rows] == [(name, who) for name in ATTENTION for who in WHO]
    shares = {(row["attention"], row["reacting"]): row["value"] for row in rows}
    assert shares["attentive", Reacting.ALL] == shares["attentive", Reacting.TO_EGO] == 0.0
    assert shares["slow", Reacting.ALL] == 1.0
    assert {shares[name, Reacting.BUT_ATTACKER] for name in ATTENTION} == {1.0}


def test_deaf_is_who_was_exchanged_and_without_one_who_is_hit():
    stands, comes, law = crossed(0.0), crossed(9.8), params().reaction
    driver = plugins.make("drivers", "idm", params().drivers, "survival.drivers")
    both = replays([stands, comes], [stands.log, comes.log], [comes.log, comes.log], driver, law)
    assert [replay.deaf for replay in both] == [1, 1]
    assert replays([stands], [stands.log], [stands.log], driver, law)[0].deaf == 0  # nobody moves otherwise, nobody is hit


def test_the_table_has_a_line_for_each_adversary_and_a_column_for_who_reacts(made, tmp_path):
    place = tmp_path / "runs/7"
    run(made, place)
    write_json(place / "reports/metrics/attack/idm.json", {})
    publish_corner.main(publish_corner.Params(7, [7], {}, 20), tmp_path / "runs", tmp_path / "out")
    text = (tmp_path / "out/survival.md").read_text()
    assert f"| driver |  | cases | {' | '.join(f'reacting: {who}' for who in WHO)} |" in text
    [line] = [line for line in text.splitlines() if line.startswith("| idm |")]
    assert line.startswith("| idm | random goals | 1 |")
    assert line.endswith("| 1.00 (attentive 1.00; slow 1.00) | 0.00 (attentive 0.00; slow 1.00) |")  # one recording: no interval
    assert len(orjson.loads((tmp_path / "out/survival.json").read_bytes())) == len(ATTENTION) * len(WHO)
