"""Tracks, and each planner trained on them."""

import pytest

from drivegen.core import plugins
from drivegen.planners.base import Examples, Planner
from tests.planners.tiny import examples, tiny


@pytest.fixture(scope="module")
def logs() -> Examples:
    return examples()


@pytest.fixture(scope="module", params=plugins.names("planners"))
def trained(request: pytest.FixtureRequest, logs: Examples) -> Planner:
    planner = tiny(request.param)
    planner.fit([logs], logs[:4], 7, None, lambda line: None)
    return planner
