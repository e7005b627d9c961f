"""What many tests share and takes seconds to make."""

from pathlib import Path

import pytest

from tests.models import write_models


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of models as the pipeline leaves it, trained for seconds: see tests/models.py."""
    return write_models(tmp_path_factory.mktemp("models"))
