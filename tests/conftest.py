"""What many tests share and takes seconds to make."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from stages._door import one_thread  # says it when it is imported, too: the next import brings torch
from tests.models import write_models

# As stages/run has it, and before torch is there, which reads it once: two threads on a busy machine spin a minute away.
one_thread()

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
    """Flows first, the whole pipeline in the middle, between two modules.

    Of two workers one compiles what most tests run while the other waits for flows, which run nothing of it. The pipeline runs in
    a copy of this tree, which takes along what has been compiled by then: a minute's work. Enough is left to run beside it.
    """
    paths = [item.path for item in items]
    half = paths.index(paths[len(items) // 2]) if items else 0

    def turn(numbered: tuple[int, pytest.Item]) -> int:
        number, item = numbered
        if item.get_closest_marker("slow"):
            return 2
        return 0 if item.path.parent.name == "flows" else 1 if number < half else 3

    items[:] = [item for _, item in sorted(enumerate(items), key=turn)]
