"""`python -m flows`: what it says and how it exits, with no flow and no server behind it."""

import signal
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
        (RuntimeError("the local Prefect server did not start"), 1, "flows: the local Prefect server did not start\n"),
    ],
)
def test_what_stops_a_flow_is_one_line_and_an_exit_code(monkeypatch, capsys, fault, code, said):
    def fail(_: object) -> None:
        raise fault

    monkeypatch.setattr(command, "_run", fail)
    assert command.main(["experiment"]) == code
    assert capsys.readouterr().err == said
