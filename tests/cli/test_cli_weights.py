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
    (tmp_path / "circle").symlink_to("circle")
    assert call(monkeypatch, tmp_path, "save", "circle") == 2
    assert "circle is there and no plain file" in capsys.readouterr().err
    assert [file.read_text() for file in weights.parent.iterdir()] == ["{}"]
    assert call(monkeypatch, tmp_path, "save", "models.zip") == 0


def test_what_is_not_there_is_told_with_what_to_do(tmp_path, monkeypatch, capsys):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/a.txt").touch()
    for words, code, why in (
        (("load", "nosuch"), 2, "nosuch is no file: name one that `drivegen weights save` wrote"),
        (
            ("save", "models.zip"),
            1,
            "data/models holds no trained models: `make run` trains them, in the project's folder: change",
        ),
        (("save", "models.zip", "--models", "wrong"), 2, "wrong is not the folder of trained models, it holds nothing: name the"),
        (
            ("save", "models.zip", "--models", "mine"),
            2,
            "mine is not the folder of trained models, it holds something else, mine/a",
        ),
    ):
        assert call(monkeypatch, tmp_path, *words) == code
        assert why in capsys.readouterr().err
    assert [place.name for place in tmp_path.iterdir()] == ["mine"]
