"""The stage `naturalness` on hand-made cases, and its published table."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import orjson
import pytest

from drivegen.adversaries.shared.legal import legal
from drivegen.adversaries.shared.naturalness import exchanged, naturalness
from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Samples
from drivegen.store.files import write_json
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from stages import naturalness as stage
from stages import publish_corner
from stages._cases import read_traffic
from stages._door import read_params
from tests.drivers.taught import PARAMS
from tests.generators.rivals import trained
from tests.stages.crossing_cases import SHARD, scene, write_cases


class Slow:
    """Holds who is slow for likely: less 1 nat for each [m/s]."""

    def log_likelihood(self, scenarios, traffic):
        return [-motion.speed.mean(-1).astype(np.float64) for motion in traffic]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """Three scenes, in two of which IDM's case is that somebody drives across, and SMART after a few steps."""
    write_cases(root := tmp_path_factory.mktemp("naturalness"))
    trained("smart")[0].save(root / "models/generators/smart")
    return root


def run(made: Path, out: Path, **other: object) -> list[dict[str, object]]:
    small = {"attacks": ["random.legal.10", "cat.legal.10"], "drivers": ["idm"], "draws": 20, **other}
    params = replace(read_params("naturalness", stage.Params, PARAMS), **small)
    stage.main(params, made / "test", made / "models", made / "round", made / "attack", out / "naturalness.json")
    return orjson.loads((out / "naturalness.json").read_bytes())


def test_the_vehicles_that_were_exchanged_are_judged_as_they_move_and_as_they_did_before():
    before, after = scene(0), scene(0, 10.0)
    assert exchanged(before.log, after.log).tolist() == [1]
    assert exchanged(before.log, before.log).tolist() == []
    found = naturalness(Slow(), [before, before], [before.log, before.log], [after.log, before.log])
    np.testing.assert_allclose(found[0], [-10.0, 0.0], atol=1e-3)
    assert np.isnan(found[1]).all()


def test_who_was_left_out_as_illegal_is_not_among_who_was_exchanged(tmp_path):
    write_shard(tmp_path / "test" / SHARD, [scene(0)])
    sample = Samples.without_goals("run0-0", "drivegen", scene(0).log[np.newaxis])
    sample.violation[0, 1] = 1
    write_samples(tmp_path / "round" / SHARD, [sample])
    [(_, [before])] = read_traffic(tmp_path / "test", tmp_path / "round").values()
    after = legal(sample, 0)  # what attacks start from
    assert exchanged(scene(0).log, after).tolist() == [1]
    assert exchanged(before, after).tolist() == []


def test_who_is_not_there_both_times_counts_for_neither():
    class Blind(Slow):
        """Knows nothing of who stands."""

        def log_likelihood(self, scenarios, traffic):
            return [np.where(odds < 0, odds, np.nan) for odds in super().log_likelihood(scenarios, traffic)]

    before, after = scene(0), scene(0, 10.0)
    assert np.isnan(naturalness(Blind(), [before], [before.log], [after.log])).all()


def test_a_row_for_what_attackers_do_for_what_they_did_and_for_the_difference(made, tmp_path):
    attack, before, less = run(made, tmp_path)
    about = {"method": "random", "allowed": "legal", "found_for": "idm", "n": 2}
    assert {key: attack[key] for key in about} == about
    assert [row["metric"] for row in (attack, before, less)] == list(stage.METRICS)
    assert less["value"] == pytest.approx(attack["value"] - before["value"])
    assert max(attack["value"], before["value"]) < 0


def test_who_says_no_likelihood_is_no_judge(made, tmp_path):
    with pytest.raises(UnusableInput, match=r"naturalness\.judge is 'bits', which has no log_likelihood"):
        run(made, tmp_path, judge="bits")


def test_the_table_has_a_line_for_each_attack(made, tmp_path):
    place = tmp_path / "runs/7"
    write_json(place / publish_corner.NATURAL, run(made, tmp_path))
    write_json(place / "reports/metrics/attack/idm.json", {})
    publish_corner.main(publish_corner.Params(7, [7], {}, 20), tmp_path / "runs", tmp_path / "out")
    text = (tmp_path / "out/naturalness.md").read_text()
    assert "| random goals | legal | idm | 2 | -" in text
    assert {row["seeds"] for row in orjson.loads((tmp_path / "out/naturalness.json").read_bytes())} == {1}


def test_where_nobody_was_exchanged_there_is_no_table(tmp_path):
    place = tmp_path / "runs/7"
    write_json(place / publish_corner.NATURAL, [])
    write_json(place / "reports/metrics/attack/idm.json", {})
    publish_corner.main(publish_corner.Params(7, [7], {}, 20), tmp_path / "runs", tmp_path / "out")
    assert not (tmp_path / "out/naturalness.md").exists()


def test_a_name_that_is_no_attack_is_one_sentence():
    with pytest.raises(UnusableInput, match=r"naturalness.attacks: 'cat' is no <method>.<allowed>.<queries>"):
        replace(read_params("naturalness", stage.Params, PARAMS), attacks=["cat"])
