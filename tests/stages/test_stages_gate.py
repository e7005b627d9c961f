"""The stage `gate`: two versions of a driver in futures of hand-made scenes, and what params.yaml may not say."""

import json

import numpy as np
import pytest

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.samples import Samples
from drivegen.corner_cases.gate import Settings
from drivegen.store.samples import write_samples
from drivegen.store.scenarios import write_shard
from stages import gate
from stages._door import read_section
from tests.drivers.taught import PARAMS
from tests.scenes import drive, scenario, stack, straight_road

LINE = straight_road(600).centreline[0].astype(np.float64)
SETTINGS = Settings(alarms=0.05, avoidable=False, draws=50)


def params(**versions) -> gate.Params:
    return gate.Params(7, SETTINGS, {"idm": read_section("gate.drivers.idm", PARAMS)}, **versions)


@pytest.fixture
def folder(tmp_path):
    """Six recordings with two futures each: somebody stands in the way, and nobody does."""
    logs = [stack([drive(LINE, 20, 12, 101), drive(LINE, 80.0 + n, 0, 101)]) for n in range(6)]
    write_shard(
        tmp_path / "test/shard-00000.parquet", [scenario(straight_road(600), log, f"r{n}-0") for n, log in enumerate(logs)]
    )
    free = stack([drive(LINE, 20, 12, 101), drive(LINE, 500, 0, 101)])
    futures = [Samples.without_goals(f"r{n}-0", "drivegen", stack([log, free])) for n, log in enumerate(logs)]
    write_samples(tmp_path / "made/shard-00000.parquet", futures)
    return tmp_path


def test_a_worse_version_is_recorded_and_the_stage_succeeds(folder):
    ask = params(old={"idm": None}, new={"idm": {"emergency_braking": 0.5}})
    assert gate.main(ask, folder / "test", folder / "made", folder / "gate.json") == {"runs": 12.0}
    record = json.loads((folder / "gate.json").read_text())
    assert record["finding"] == "worse"
    assert record["collisions"] == {"old": 0, "new": 6, "only_old": 0, "only_new": 6}
    assert record["drivers"]["new"] == {"idm": {"emergency_braking": 0.5}}
    assert {row["sample"] for row in record["differ"]} == {0}
    assert record["sentence"].startswith(
        "worse: in 12 runs of 6 recordings the new idm has 6 counted collisions more than the old idm"
    )


@pytest.mark.parametrize(
    ("new", "why"),
    [
        ({}, "gate.new must be a driver's name"),
        ({"idm": {}, "gail": {}}, "gate.new must be a driver's name"),
        ({"idm": 3}, "gate.new must be a driver's name"),
        ({"idm": {"nothing": 1.0}}, "gate.new: idm: unknown name 'nothing'"),
        ({"gail": {}}, "gate.drivers has no settings for 'gail'"),
    ],
)
def test_versions_that_make_no_sense_are_named(folder, new, why):
    with pytest.raises(UnusableInput, match=why):
        gate.main(params(old={"idm": {}}, new=new), folder / "test", folder / "made", folder / "gate.json")


def test_without_futures_the_stage_says_what_to_run(folder):
    with pytest.raises(MissingTool, match="rollout"):
        gate.main(params(old={"idm": {}}, new={"idm": {}}), folder / "test", folder / "nothing", folder / "gate.json")
