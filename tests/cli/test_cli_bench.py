"""`drivegen bench`: what cannot be written is refused before anything is measured."""

import sys

import pytest

from drivegen import cli
from drivegen.cli import bench


@pytest.mark.parametrize("words", [(), ("maps",)])
def test_a_folder_is_no_place_for_rows(tmp_path, monkeypatch, capsys, words):
    for name in ("measure", "own_cases"):
        monkeypatch.setattr(bench, name, None)
    monkeypatch.setattr(sys, "argv", ["drivegen", "bench", *words, "--json", str(tmp_path)])
    with pytest.raises(SystemExit) as left:
        cli.main()
    assert left.value.code == 2
    assert capsys.readouterr().err == f"drivegen: {tmp_path} is there and no plain file: name another one\n"
