"""The toy pipeline that flows are tried on."""

from pathlib import Path

import pytest

from tests.flows import toy


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A pipeline of which nothing has run, and the working directory."""
    monkeypatch.chdir(toy.build(tmp_path))
    return tmp_path
