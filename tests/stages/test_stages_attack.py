"""The stage `attack` on hand-made scenes: of which inputs its results are."""

from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from torch import nn

from drivegen.drivers.shared.features import COUNT
from drivegen.drivers.shared.network import write_network
from stages import attack
from stages._door import read_params
from tests.drivers.taught import PARAMS
from tests.stages.queues import write_queues


@pytest.fixture(scope="module")
def made(tmp_path_factory, models) -> Path:
    """See `queues`."""
    write_queues(root := tmp_path_factory.mktemp("attack"), models)
    return root


def test_a_result_is_of_the_driver_s_weights_and_of_what_goals_are_made_with(made, tmp_path):
    weights, tables = tmp_path / "gail", []
    params = replace(read_params("attack", attack.Params, PARAMS), methods=["dataset"], scenarios=1, draws=20, workers=1)
    params = replace(params, drivers={"gail": {"weights": str(weights), "sees_rules": True}})
    for _ in range(2):  # other weights each time
        write_network(weights, "gail", [nn.Linear(COUNT, 1)], "tanh", squashed=False)
        out = [tmp_path / name for name in ("cases", "gail.parquet", "gail.json")]
        attack.main(params, made / "test", made / "models", made / "goals", made / "round", *out)
        tables.append(pq.read_table(out[1]))
    one, other = (set(table["run"].to_pylist()) for table in tables)
    assert len(one | other) == 2
    [read] = set(tables[0]["inputs"].to_pylist())
    expected = [
        made / "test",
        made / "goals",
        made / "round",
        made / "models/planners/route_fm",
        made / "models/limits.json",
        weights,
    ]
    assert read == " ".join(map(str, expected))
