"""`drivegen weights`: where a file of models may lie, and what is said where there is none."""

import sys

import pytest

from drivegen import cli


def call(monkeypatch, folder, *words):
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", ["drivegen", "weights", *words])
    with pytest.raises(SystemExit) as left:
        cli.main()
    return left.value.code or 0


def test_models_are_not_packed_into_their_own_folder(tmp_path, monkeypatch, capsys):
    weights = tmp_path / "data/models/selector/weights.json"
    weights.parent.mkdir(parents=True)
    weights.write_text("{}")
    for name in ("weights.json", "new.zip"):
        assert call(monkeypatch, tmp_path, "save", f"data/models/selector/{name}") == 2
        assert "name a place outside data/models" in capsys.readouterr().err
    assert [file.read_text() for file in weights.parent.iterdir()] == ["{}"]
    assert call(monkeypatch, tmp_path, "save", "models.zip") == 0
