"""What a flow says of a fault: one sentence, no traceback, and nothing of anybody else's is touched; no server here."""

import subprocess
import sys
from pathlib import Path

import pytest

from flows import FlowFailed, pipeline, workspace
from flows.corpus import corpus
from flows.regenerate import regenerate
from tests.flows import toy
from tests.flows.test_flows_pipeline import in_use


@pytest.mark.parametrize("version", ["../tables", "..", "a/b", "/tmp/version", "."])
def test_a_version_is_the_name_of_a_folder_and_deletes_nothing_elsewhere(root: Path, version: str) -> None:
    kept = root / ".drivegen" / "tables" / "run"
    kept.mkdir(parents=True)
    state = regenerate.fn(version=version)
    assert state.is_failed()
    assert str(state.message) == f"{version!r} is no name for a folder: give one without /"
    assert kept.exists()


def test_a_fault_of_a_flow_is_its_state_s_message(root: Path) -> None:
    (root / "flows").mkdir()
    (root / "flows" / "sizes.yaml").write_text("driving: {}")
    assert corpus.fn("huge", root).message == "flows/sizes.yaml has no size 'huge'; there are driving"
    (root / "flows" / "sizes.yaml").write_text("driving: {")
    assert str(corpus.fn("huge", root).message).startswith("flows/sizes.yaml is not YAML: ")
    for nameless in ("", "- driving\n"):
        (root / "flows" / "sizes.yaml").write_text(nameless)
        assert corpus.fn("huge", root).message == "flows/sizes.yaml holds no names with values"
    (root / "flows" / "sizes.yaml").unlink()
    assert "flows/sizes.yaml" in str(corpus.fn("huge", root).message)


def test_a_workspace_is_one_run_s_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with workspace.alone("tables-quality"), workspace.alone("tables-drivers"):
        second = workspace.alone("tables-quality")
        with pytest.raises(FlowFailed, match="another run is at work on tables-quality in this folder"):
            second.__enter__()
    with workspace.alone("tables-quality"):
        pass


def test_what_dvc_cannot_read_is_said_in_one_line(root: Path) -> None:
    (root / "params.yaml").write_text("run: {seed: 7\nrounds: [")
    with pytest.raises(FlowFailed, match=r"^DVC: unable to read: 'params.yaml'.* line 2.*$"):
        pipeline.read()


def test_however_long_files_take_to_come_back_they_are_waited_for(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(command: list[str], timeout: float | None = None, **_: object) -> subprocess.CompletedProcess[str]:
        if timeout is not None:
            raise subprocess.TimeoutExpired(command, timeout)
        return subprocess.CompletedProcess(command, 0)

    monkeypatch.setattr(pipeline.subprocess, "run", slow)
    pipeline.checkout(["data"], root)
    pipeline.restore(root)


def test_a_folder_without_git_is_told_what_to_do(tmp_path: Path) -> None:
    source = toy.build(tmp_path)
    (source / ".git").rename(source / "elsewhere")
    with pytest.raises(FlowFailed, match="is not a git repository, which DVC needs: clone DriveGen, or `git init`"):
        pipeline.read(source)
    with pytest.raises(FlowFailed, match="git does not know the files of"):
        workspace.duplicate(source, tmp_path / "room", {})


def test_a_stage_whose_files_another_run_has_says_whose(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipeline, "_TRIES", 1)
    (root / ".dvc" / "tmp").mkdir()
    with subprocess.Popen([sys.executable, "-c", "input()", "repro", "maps"], stdin=subprocess.PIPE) as other:
        in_use(root, other.pid, "dvc repro maps")
        with pytest.raises(pipeline.StageFailed, match=rf"maps did not run: another run .*\(PID {other.pid}\): dvc repro maps$"):
            pipeline.reproduce("maps", lambda _: None)
        other.communicate(b"\n")
