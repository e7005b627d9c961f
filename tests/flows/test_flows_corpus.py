"""The corpus in other sizes: what they ask for is there to be replaced, and is what they promise."""

from pathlib import Path

import pytest
import yaml

from drivegen.core.scenario import SPLITS
from drivegen.core.settings import build
from drivegen.layouts.corpus import Networks
from flows import FlowFailed
from flows.corpus import SIZES, overrides
from flows.workspace import overridden


@pytest.mark.parametrize("size", yaml.safe_load(SIZES.read_text()))
def test_a_size_replaces_what_params_yaml_has_and_shares_no_network_between_splits(size: str, tmp_path: Path) -> None:
    corpus = overridden(yaml.safe_load(Path("params.yaml").read_text()), overrides(size, tmp_path))["corpus"]
    networks = build(Networks, yaml.safe_load(Path(corpus["networks"]).read_text()), size)
    networks.check(corpus["scenarios"], corpus["density"])
    groups = vars(networks).values()
    of = [{str(word) for group in groups for item in group.get(split, {}).items() for word in item} for split in SPLITS]
    assert all(of)
    assert len(set().union(*of)) == sum(map(len, of))  # neither a name nor what it stands for is in two of them


def test_driving_is_tested_on_20_networks_8_of_them_not_ours_in_60_runs_or_more(tmp_path: Path) -> None:
    for name in ("acosta/acosta_buslanes.net.xml", "pasubio/pasubio_buslanes.net.xml"):
        (tmp_path / "sumo" / name).parent.mkdir(parents=True)
        (tmp_path / "sumo" / name).touch()
    size = overrides("driving", tmp_path)
    networks = build(Networks, yaml.safe_load(Path(size["corpus.networks"]).read_text()), "driving")
    there, missing = networks.located(size["corpus.outside"])
    assert missing == []
    shares = list(there.shares("test", size["corpus.scenarios"]["test"], size["corpus.own_share"]))
    assert sum(count for *_, count in shares) == 4000
    assert [kind for _, kind, _ in shares].count("real") == 8
    assert len(shares) == 20
    assert sum(-(-count // size["corpus.per_part"]) for *_, count in shares) >= 60
    assert networks.located("")[1] == ["acosta", "pasubio"]


def test_tuned_drivers_are_tested_on_seven_networks_of_our_own_that_the_default_corpus_does_not_hold() -> None:
    params = yaml.safe_load(Path("flows/tables.yaml").read_text())["drivers"]["data"]["unseen"]["params"]
    default = yaml.safe_load(Path("params.yaml").read_text())["corpus"]
    corpus = overridden({"corpus": default, "drive_tuned": {"policies": ""}}, params)["corpus"]
    every = build(Networks, yaml.safe_load(Path(corpus["networks"]).read_text()), "unseen")
    usual = build(Networks, yaml.safe_load(Path(default["networks"]).read_text()), "default")
    networks = every.chosen(corpus["only"])
    networks.check(corpus["scenarios"], corpus["density"])
    assert len(networks.own["test"]) == 7
    assert not any([*networks.real.values(), *networks.outside.values()])
    assert not set(networks.own["test"]) & {name for named in usual.own.values() for name in named}
    assert all(any(networks.shares(split, count, corpus["own_share"])) for split, count in corpus["scenarios"].items())


def test_a_size_that_is_not_there_is_told_of(tmp_path: Path) -> None:
    with pytest.raises(FlowFailed, match="driving"):
        overrides("huge", tmp_path)
