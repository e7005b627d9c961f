"""What many tests share and takes seconds to make."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from tests.models import write_models

# Flows run on the server of tests/flows or not at all: a hidden one of Prefect's own ends in tracebacks after the last test.
os.environ["PREFECT_SERVER_ALLOW_EPHEMERAL_MODE"] = "false"

# The same examples in every run, so that a failure is the fault of the change that shows it; `make fuzz` draws new ones.
settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("new", deadline=None, print_blob=True)
settings.load_profile("new" if "DRIVEGEN_FUZZ" in os.environ else "same")


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of models as the pipeline leaves it, trained for seconds: see tests/models.py."""
    return write_models(tmp_path_factory.mktemp("models"))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The slowest module first, so that it runs beside all the others (stable: the rest keep their order)."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)
