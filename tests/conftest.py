"""What many tests share and takes seconds to make."""

import os
from pathlib import Path

import pytest

from tests.models import write_models

# Prefect reads its settings once. Whatever imports it first, a server that starts beside a busy test has time to.
os.environ.setdefault("PREFECT_SERVER_EPHEMERAL_STARTUP_TIMEOUT_SECONDS", "180")


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of models as the pipeline leaves it, trained for seconds: see tests/models.py."""
    return write_models(tmp_path_factory.mktemp("models"))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The slowest module first, so that it runs beside all the others (stable: the rest keep their order)."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)
