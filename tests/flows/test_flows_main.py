"""`python -m flows`: what it says and how it exits, with no flow and no server behind it."""

import os
import signal
import threading
from contextlib import nullcontext

import pytest

from flows import __main__ as command


@pytest.fixture(autouse=True)
def _no_server(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command.server, "local_server", lambda meanwhile: nullcontext())


@pytest.mark.parametrize(
    ("fault", "code", "said"),
    [
        (KeyboardInterrupt(), 130, "flows: stopped; stages that were done stay done, the same command goes on from there\n"),
        (
            command.Stopped(signal.SIGTERM),
            143,
            "flows: stopped; stages that were done stay done, the same command goes on from there\n",
        ),
        (OSError("no space left"), 1, "flows: no space left\n"),
        (RuntimeError("the local Prefect server did not start"), 1, "flows: the local Prefect server did not start\n"),
    ],
)
def test_what_stops_a_flow_is_one_line_and_an_exit_code(monkeypatch, capsys, fault, code, said):
    def fail(_: object) -> None:
        raise fault

    monkeypatch.setattr(command, "_run", fail)
    assert command.main(["experiment"]) == code
    assert capsys.readouterr().err == said


def test_what_fails_because_it_was_stopped_was_stopped(monkeypatch, capsys):
    def clean_up_what_was_not_begun(_: object) -> None:
        lock = threading.Lock()
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            threading.Event().wait(10)
        finally:
            lock.release()

    monkeypatch.setattr(command, "_run", clean_up_what_was_not_begun)
    monkeypatch.setattr(command.attended, "stopping_work", nullcontext)  # which remembers for good that it was stopped
    assert command.main(["experiment"]) == 143
    assert capsys.readouterr().err.startswith("flows: stopped;")


def test_real_data_that_is_named_and_not_there_is_not_left_out_in_silence(monkeypatch, capsys):
    with pytest.raises(SystemExit) as stop:
        command.main(["tables", "--real", "no/such/folder"])
    assert stop.value.code == 2
    assert "argument --real: no/such/folder is no folder" in capsys.readouterr().err
    monkeypatch.setenv("DRIVEGEN_REAL_DATA", "nowhere")
    with pytest.raises(SystemExit):
        command.main(["corpus", "driving"])
    assert "argument --real: nowhere is no folder" in capsys.readouterr().err
    monkeypatch.setattr(command, "_run", lambda arguments: (_ for _ in ()).throw(RuntimeError(str(arguments))))
    command.main(["iterate"])  # which reads none
    assert "min_gain=0.0" in capsys.readouterr().err


def test_every_part_of_the_tables_is_explained(capsys):
    with pytest.raises(SystemExit):
        command.main(["tables", "--help"])
    words = capsys.readouterr().out
    assert all(f"{part}:" in words for part in command.PARTS)
