"""The toy pipeline that flows are tried on."""

import shutil
from pathlib import Path

import pytest

from flows import pipeline
from tests.flows import toy


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A pipeline of which nothing has run, and the working directory."""
    monkeypatch.chdir(toy.build(tmp_path))
    return tmp_path


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pipeline of which everything has run: to be copied."""
    folder = toy.build(tmp_path_factory.mktemp("built"))
    for stage in pipeline.read(folder).needs:
        assert pipeline.reproduce(stage, lambda _: None, folder)
    return folder


@pytest.fixture
def done(built: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, and the working directory."""
    root = tmp_path / "done"
    shutil.copytree(built, root, symlinks=True)
    monkeypatch.chdir(root)
    return root
