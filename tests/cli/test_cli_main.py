"""What holds for every command: how it is stopped, names that no terminal shows, warnings, where compiled code is kept."""

import json
import os
import signal
import subprocess
import sys
import warnings

import pytest

from drivegen import cli

COMMAND = [sys.executable, "-c", "from drivegen.cli import main; main()"]

INTERRUPTED = """
import os, signal, sys
from drivegen.cli import main, query
def interrupted(*_):
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        signal.pause()
    except SystemExit:
        raise RuntimeError("Query interrupted")  # as DuckDB does
query.query = interrupted
main()
"""


def test_the_exit_code_is_the_signal_s_whatever_a_library_makes_of_it(tmp_path):
    done = subprocess.run([sys.executable, "-c", INTERRUPTED, "query"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (128 + signal.SIGTERM, "drivegen: stopped; nothing half-written was kept\n")


def test_a_name_that_is_not_utf_8_can_be_read_and_told(tmp_path):
    def run(*words: str | bytes) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
        return subprocess.run(
            [*COMMAND, "map", *words], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )

    done = run("a straight road", "--out", "ü7")
    assert done.returncode == 0, done.stderr
    assert r"\xfc7/map.net.xml" in done.stdout
    name = b"n\xfcber.net.xml"
    (tmp_path / "ü7" / "map.net.xml").rename(tmp_path / os.fsdecode(name))
    done = run("import", name, "--out", "there")
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "there" / "map.json").read_text())["text"] == "SUMO network: n?ber.net.xml"


def call(monkeypatch, command, *words):
    """Exit code of a command in place of `map`."""
    monkeypatch.setattr(cli, "build", lambda _: lambda: sys.exit(command()))
    monkeypatch.setattr(sys, "argv", ["drivegen", "map", *words])
    try:
        cli.main()
    except SystemExit as left:
        return left.code or 0
    return 0


@pytest.mark.parametrize("words", [("--out", ""), ("--out=",)])
def test_an_empty_path_is_not_the_current_folder(monkeypatch, capsys, words):
    assert call(monkeypatch, lambda: None, "a straight road", *words) == 2
    assert capsys.readouterr().err == "drivegen: --out is empty: name a file or a folder\n"


def test_a_warning_is_one_line_without_our_code(monkeypatch, capsys):
    def warn() -> None:
        warnings.simplefilter("always")
        warnings.warn("scenes: left out:\n1", stacklevel=1)

    before = warnings.showwarning
    assert call(monkeypatch, warn) == 0
    assert capsys.readouterr().err == "drivegen: scenes: left out: 1\n"
    assert warnings.showwarning is before
