"""Another device adds in another order: the same weights, requests and noise give the same motion to the centimetre.

Where there is no GPU, sums in double precision stand in for the other device: they differ from any device's by its rounding.
"""

import numpy as np
import pytest
import torch
from torch import Tensor

from drivegen.planners.base import Examples, Planner
from drivegen.planners.shared.flow import FlowNet
from drivegen.training import loop

TOLERANCE = 0.01
"""Of positions [m], as docs/commands.md states it."""

pytestmark = pytest.mark.parametrize("trained", ["route_fm", "poly_fm"], indirect=True, scope="module")


def positions(planner: Planner, logs: Examples) -> np.ndarray:
    return planner.sample(logs.scenarios, logs.requests).position


def test_rounding_moves_nobody_by_a_centimetre(trained: Planner, logs: Examples, monkeypatch: pytest.MonkeyPatch) -> None:
    here, single = positions(trained, logs), FlowNet.sample

    def double(net: FlowNet, features: Tensor, noise: Tensor, steps: int) -> Tensor:
        found = single(net.double(), features.double(), noise.double(), steps).float()
        net.float()
        return found

    monkeypatch.setattr(FlowNet, "sample", double)
    there = positions(trained, logs)
    assert 0 < np.abs(here - there).max() < TOLERANCE


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU here")
def test_a_gpu_plans_the_same_motion(trained: Planner, logs: Examples, monkeypatch: pytest.MonkeyPatch) -> None:
    there = positions(trained, logs)
    monkeypatch.setattr(loop, "device", lambda: torch.device("cpu"))
    assert np.abs(positions(trained, logs) - there).max() < TOLERANCE
