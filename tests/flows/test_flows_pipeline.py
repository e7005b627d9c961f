"""What flows know of DVC, on a pipeline of shell commands; no Prefect here."""

import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import yaml
from dvc.repo import Repo

from flows import FlowFailed, pipeline, workspace
from flows.costs import COSTS
from flows.experiment import stages_at_once
from tests.flows import toy


def run_stale() -> list[str]:
    plan = pipeline.read()
    return [stage for stage in plan.needs if stage in plan.stale and pipeline.reproduce(stage, lambda _: None)]


def test_stages_come_in_an_order_in_which_they_can_run(root):
    plan = pipeline.read()
    order = list(plan.needs)
    assert plan.needs["place"] == ["ingest", "maps"]
    assert all(order.index(before) < order.index(stage) for stage, needs in plan.needs.items() for before in needs)
    assert plan.up_to("corner@1") == ["ingest", "corner@0", "corner@1"]
    assert plan.stale == set(order)


def test_only_what_a_change_reaches_is_stale(done):
    assert pipeline.read().stale == frozenset()
    (done / "dvc.yaml").write_text(toy.DVC.replace("cat data/maps data/scenarios", "cat data/scenarios data/maps"))
    assert pipeline.read().stale == {"place", "ship"}
    assert sorted(run_stale()) == ["place", "ship"]


def test_a_stage_whose_inputs_come_out_equal_is_not_run_again(done):
    (done / "dvc.yaml").write_text(toy.DVC.replace("grep -o", "grep  -o"))
    assert pipeline.read().stale == {"maps", "place", "ship"}
    assert run_stale() == ["maps"]


@pytest.mark.parametrize("stages", [0, -1, "two", None, 1.5])
def test_how_many_stages_run_at_once_is_said_by_a_count(tmp_path: Path, stages: object):
    params = tmp_path / "params.yaml"
    params.write_text(yaml.safe_dump({"run": {"stages": 3}}))
    assert stages_at_once(params) == 3
    params.write_text(yaml.safe_dump({} if stages is None else {"run": {"stages": stages}}))
    with pytest.raises(FlowFailed, match=r"params.yaml: run.stages is .*: say how many stages run at once, 1 or more"):
        stages_at_once(params)


def test_lines_are_streamed_and_hints_left_out(root):
    lines: list[str] = []
    assert pipeline.reproduce("ingest", lines.append)
    assert any("mkdir -p data" in line for line in lines)
    assert not any("git add" in line for line in lines)
    assert not pipeline.reproduce("ingest", lines.append)


def test_a_failed_stage_says_its_own_last_words(root):
    (root / "dvc.yaml").write_text(toy.DVC.replace("echo logs >", "echo ingest, no such folder && false >"))
    with pytest.raises(pipeline.StageFailed, match="stage ingest failed: ingest, no such folder"):
        pipeline.reproduce("ingest", lambda _: None)


def test_a_stage_that_calls_something_busy_as_it_fails_is_not_run_again(root, monkeypatch):
    monkeypatch.setattr(pipeline, "_TRIES", 2)
    (root / "dvc.yaml").write_text(toy.DVC.replace("echo logs >", "echo once >> ran; echo 'the road is busy' && false >"))
    with pytest.raises(pipeline.StageFailed, match="stage ingest failed: the road is busy"):
        pipeline.reproduce("ingest", lambda _: None)
    assert (root / "ran").read_text() == "once\n"


def test_a_stage_whose_files_are_held_waits_for_them(root):
    (root / "dvc.yaml").write_text(toy.DVC.replace("cat data/maps", "sleep 2; cat data/maps"))
    for stage in ("ingest", "maps"):
        pipeline.reproduce(stage, lambda _: None)
    (root / "params.yaml").write_text(toy.PARAMS.replace("seed: 7", "seed: 8"))  # `ingest` depends on it
    holder = threading.Thread(target=pipeline.reproduce, args=("place", lambda _: None))
    holder.start()
    lines: list[str] = []
    assert pipeline.reproduce("ingest", lines.append)  # it rewrites what `place` reads
    holder.join()


def test_who_asks_while_another_run_holds_the_workspace_waits_for_it(done):
    plans: list[pipeline.Pipeline] = []
    asking = threading.Thread(target=lambda: plans.append(pipeline.read()))
    with Repo(str(done)) as other, other.lock:
        asking.start()
        asking.join(1.0)
        assert asking.is_alive()
    asking.join(30.0)
    assert plans[0].stale == frozenset()


def test_outputs_inputs_and_metrics_are_those_of_dvc_yaml(done):
    assert pipeline.outputs("ship") == ["data/shipped", "data/ship.json"]
    assert sorted(pipeline.inputs("place")) == ["data/maps", "data/scenarios"]
    assert pipeline.metrics("ship") == {"scenarios": 1}
    with pytest.raises(pipeline.StageFailed, match="writes no JSON file"):
        pipeline.metrics("place")
    (done / "data" / "ship.json").unlink()
    with pytest.raises(pipeline.StageFailed, match=r"has not written .*ship\.json"):
        pipeline.metrics("ship")


def test_a_second_workspace_shares_the_cache_and_has_its_own_params(done, tmp_path):
    room = tmp_path / "room"
    workspace.duplicate(done, room, {"run.seed": 8})
    pipeline.checkout(["data/scenarios"], room)
    assert (room / "data" / "scenarios").read_text() == "logs\n"
    assert pipeline.reproduce("maps", lambda _: None, room)
    assert (room / "data" / "maps").read_text().strip() == "seed: 8"
    assert (done / "data" / "maps").read_text().strip() == "seed: 7"
    assert not (room / ".dvc" / "cache").exists()


def test_a_second_workspace_begins_with_what_was_compiled_of_the_same_code(done, tmp_path):
    for name in ("code/motion.py", "code/__pycache__/motion.f-1.nbi", "elsewhere/__pycache__/old.pyc"):
        (done / name).parent.mkdir(parents=True, exist_ok=True)
        (done / name).write_text("x")
    (done / ".gitignore").write_text("__pycache__/\n")
    room = tmp_path / "room"
    workspace.duplicate(done, room, {})
    assert (room / "code/__pycache__/motion.f-1.nbi").exists()
    assert (room / "code/motion.py").stat().st_mtime == (done / "code/motion.py").stat().st_mtime
    assert not (room / "elsewhere").exists()
    (done / "code/__pycache__/motion.f-1.nbi").write_text("y")
    workspace.share_compiled(done, room)
    assert (room / "code/__pycache__/motion.f-1.nbi").read_text() == "y"


def test_overrides_replace_values_and_refuse_unknown_names():
    values = {"run": {"seed": 7, "workers": 2}, "rounds": [1, 2]}
    over = {"run.seed": 8, "rounds": [3]}
    assert workspace.overridden(values, over) == {"run": {"seed": 8, "workers": 2}, "rounds": [3]}
    assert values["run"]["seed"] == 7
    for unknown in ("run.speed", "run.speeds.car", "run.seed.first", "walk.seed"):
        with pytest.raises(FlowFailed, match=f"^the parameters have no '{unknown}' to replace$"):
            workspace.overridden(values, {unknown: 1})


def test_what_is_like_another_section_may_be_told_more_than_stands_there():
    values = {"rank": {"drivers": {"like": "drive.drivers"}}}
    over = {"rank.drivers.idm.headway": 1.0, "rank.drivers.gail": {}}
    assert workspace.overridden(values, over) == {
        "rank": {"drivers": {"like": "drive.drivers", "idm": {"headway": 1.0}, "gail": {}}}
    }


def test_an_override_is_written_into_the_file_that_has_its_section(tmp_path: Path):
    (tmp_path / "stages").mkdir()
    (tmp_path / "params.yaml").write_text("run: {seed: 7}")
    (tmp_path / "stages/params.yaml").write_text("rank: {samples: 4}")
    workspace.override(tmp_path, {"run.seed": 8, "rank.samples": 2})
    assert [yaml.safe_load((tmp_path / name).read_text()) for name in workspace.PARAMS] == [
        {"run": {"seed": 8}},
        {"rank": {"samples": 2}},
    ]
    with pytest.raises(FlowFailed, match=r"no section for 'tune\.seeds'"):
        workspace.override(tmp_path, {"tune.seeds": [1]})


def test_what_is_discarded_is_made_again_and_nothing_else_goes(done: Path):
    pipeline.discard(["ship", "a stage that never ran"], done)
    assert not (done / "data/shipped").exists()
    assert not (done / "data/ship.json").exists()
    assert (done / "data/placed").exists()
    assert "ship" in pipeline.read().stale
    pipeline.reproduce("ship", lambda _: None)
    assert (done / "data/shipped/shard").exists()


def test_what_the_parameters_name_no_longer_goes_and_comes_back_from_the_cache(done: Path):
    before = pipeline.locked(done)
    assert pipeline.discard_gone(done) == []
    (done.parent / "theirs").write_text("kept")
    wider = {"cmd": "x", "outs": [{"path": path} for path in ("data", "../theirs", ".", "data/shipped/shard")]}
    renamed = {**before, "under its old name": before["ship"], "of all data": wider}
    (done / "dvc.lock").write_text(yaml.safe_dump({"schema": "2.0", "stages": renamed}))
    assert pipeline.discard_gone(done) == ["of all data", "under its old name"]
    assert (done / "data/shipped/shard").exists()  # another stage writes it, or a part of it, today
    assert (done.parent / "theirs").exists()
    whole = (done / "params.yaml").read_text()
    toy.keep_rounds(done, 3)
    took = [done / COSTS / f"corner-{k}.parquet" for k in (2, 3)]
    took[0].parent.mkdir(parents=True)
    for file in took:
        file.write_text("an hour")
    assert pipeline.discard_gone(done) == ["corner@3"]
    assert [file.exists() for file in took] == [True, False]
    assert not list((done / "data").glob("round-3*"))
    assert (done / "data/round-2").exists()
    assert pipeline.locked(done) == {name: entry for name, entry in before.items() if name != "corner@3"}
    assert "corner@2" not in pipeline.read().stale
    (done / "params.yaml").write_text(whole)
    took[1].write_text("an hour, of another run since")
    assert not pipeline.reproduce("corner@3", lambda _: None)  # DVC's run cache has it
    assert (done / "data/round-3").exists()
    assert not pipeline.reproduce("corner@2", lambda _: None)  # nothing has changed
    assert [file.exists() for file in took] == [True, False]


def test_what_is_forgotten_leaves_the_rest_up_to_date(done: Path):
    pipeline.forget_all_but(pipeline.read().upstream("place"), done)
    assert pipeline.read().stale == set(pipeline.read().needs) - {"ingest", "maps"}
    assert not pipeline.reproduce("maps", lambda _: None)


def test_a_cut_off_lock_file_is_noticed_kept_aside_and_costs_no_work(done, caplog):
    made = {file: file.read_bytes() for file in (done / "data").rglob("*") if file.is_file()}
    whole = (done / "dvc.lock").read_bytes()
    for length in (0, 1, len(whole) // 3, len(whole) - 9, len(whole) - 1):
        (done / "dvc.lock").write_bytes(whole[:length])
        assert "ship" in pipeline.read().stale
        assert "dvc.lock was cut off or broken" in caplog.text
        assert (done / ".drivegen" / "damaged" / "dvc.lock").read_bytes() == whole[:length]
        assert not (done / "dvc.lock").exists()
        caplog.clear()
    assert not pipeline.reproduce("place", lambda _: None)  # DVC's run cache knows what comes out
    assert not pipeline.reproduce("ship", lambda _: None)
    assert {file: file.read_bytes() for file in made} == made


def test_a_cut_off_lock_file_is_restored_from_the_commit(done, caplog):
    whole = (done / "dvc.lock").read_bytes()
    author = ["-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["add", "dvc.lock"], [*author, "commit", "-qm", "lock"]):
        subprocess.run(["git", *words], cwd=done, check=True)
    (done / "dvc.lock").write_bytes(whole[:-100])
    assert pipeline.read().stale == frozenset()
    assert (done / "dvc.lock").read_bytes() == whole
    assert "the committed one takes its place (what was there: .drivegen/damaged/dvc.lock)" in caplog.text
    caplog.clear()
    assert pipeline.read().stale == frozenset()
    assert caplog.text == ""


@pytest.mark.parametrize("left", ["", '{"write": {"', "[]", '{"read": {"data/maps": 3}}'])
def test_a_broken_list_of_files_in_use_is_begun_anew(done, caplog, left):
    (done / ".dvc" / "tmp" / "rwlock").write_text(left)
    assert pipeline.read().stale == frozenset()
    assert "rwlock, DVC's list of files in use, was broken" in caplog.text
    assert not pipeline.reproduce("maps", lambda _: None)


def in_use(root: Path, pid: int, cmd: str) -> None:
    held = {"write": {str(root / "data" / "maps"): {"pid": pid, "cmd": cmd}}, "read": {}}
    (root / ".dvc" / "tmp" / "rwlock").write_text(json.dumps(held))


def test_files_in_use_by_a_number_that_another_process_has_now_are_free(done, caplog):
    in_use(done, os.getpid(), "dvc/__main__.py repro --single-item maps")
    assert pipeline.read().stale == frozenset()
    assert "a run which was killed had in use are free again" in caplog.text


def test_files_in_use_by_a_run_that_goes_on_are_waited_for_and_then_named(done, monkeypatch):
    monkeypatch.setattr(pipeline, "_TRIES", 2)
    with subprocess.Popen([sys.executable, "-c", "input()", "repro", "maps"], stdin=subprocess.PIPE) as other:
        in_use(done, other.pid, "dvc repro maps")
        with pytest.raises(FlowFailed, match=rf"another run has files in use.*PID {other.pid}\): dvc repro maps$"):
            pipeline.read()
        threading.Timer(0.7, other.communicate, [b"\n"]).start()
        monkeypatch.setattr(pipeline, "_TRIES", 40)
        assert pipeline.read().stale == frozenset()
