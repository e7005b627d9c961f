"""Models in one file come back as they were, and nothing else comes out of such a file."""

import os
import zipfile

import pytest

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.store.bundle import MANIFEST, pack, unpack


@pytest.fixture
def models(tmp_path):
    folder = tmp_path / "models"
    for name, content in {"limits.json": b"{}", "planners/p/weights.safetensors": bytes(range(256))}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


def test_models_come_back_byte_for_byte_and_equal_models_give_equal_files(models, tmp_path):
    assert pack(models, tmp_path / "a.zip") == ["limits.json", "planners/p/weights.safetensors"]
    unpack(tmp_path / "a.zip", tmp_path / "there")
    pack(tmp_path / "there", tmp_path / "b.zip")
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    assert (tmp_path / "there/planners/p/weights.safetensors").read_bytes() == bytes(range(256))


def test_a_file_that_was_cut_off_or_changed_is_refused_and_leaves_nothing(models, tmp_path):
    pack(models, tmp_path / "a.zip")
    content = bytearray((tmp_path / "a.zip").read_bytes())
    (tmp_path / "cut.zip").write_bytes(content[: len(content) // 2])
    content[content.index(bytes(range(256))) + 7] ^= 1
    (tmp_path / "changed.zip").write_bytes(content)
    for name in ("cut.zip", "changed.zip"):
        with pytest.raises(UnusableInput, match=name):
            unpack(tmp_path / name, tmp_path / "there")
    assert not (tmp_path / "there").exists()


@pytest.mark.parametrize("name", ["../out.json", "/out.json", "run.py", "a/../../out.json"])
def test_names_that_lie_elsewhere_or_are_no_models_are_refused(tmp_path, name):
    with zipfile.ZipFile(tmp_path / "bad.zip", "w") as archive:
        archive.writestr(MANIFEST, f'{{"sha256": {{"{name}": "0"}}}}')
        archive.writestr(name, b"x")
    with pytest.raises(UnusableInput, match="names a file that is no model of ours"):
        unpack(tmp_path / "bad.zip", tmp_path / "there")


def test_a_list_where_the_manifest_has_names_and_digests_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "bad.zip", "w") as archive:
        archive.writestr(MANIFEST, '{"sha256": ["a.json"]}')
    with pytest.raises(UnusableInput, match=r"bad\.zip has no list of models"):
        unpack(tmp_path / "bad.zip", tmp_path / "there")


def test_names_that_are_no_text_are_refused_when_packed_and_unpacked(models, tmp_path):
    (models / "grün.json").write_bytes(b"{}")
    pack(models, tmp_path / "a.zip")
    raw = (tmp_path / "a.zip").read_bytes()
    (tmp_path / "a.zip").write_bytes(raw.replace("grün".encode(), b"gr\xff\xffn"))
    with pytest.raises(UnusableInput, match=r"a\.zip is no file of"):
        unpack(tmp_path / "a.zip", tmp_path / "there")
    (models / os.fsdecode(b"gr\xffn.json")).write_bytes(b"{}")
    with pytest.raises(UnusableInput, match="rename it first"):
        pack(models, tmp_path / "b.zip")
    assert not (tmp_path / "b.zip").exists()


def test_what_is_compressed_is_refused_before_it_is_unpacked(tmp_path):
    with zipfile.ZipFile(tmp_path / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(MANIFEST, '{"sha256": {"a.json": "0"}}')
        archive.writestr("a.json", bytes(1 << 24))
    with pytest.raises(UnusableInput, match=r"bomb\.zip is compressed or encrypted"):
        unpack(tmp_path / "bomb.zip", tmp_path / "there")
    assert not (tmp_path / "there").exists()


def test_what_lies_twice_in_a_bundle_or_asks_for_a_later_format_is_refused(models, tmp_path):
    pack(models, tmp_path / "a.zip")
    raw = (tmp_path / "a.zip").read_bytes()
    larger, later = raw.replace((256).to_bytes(4, "little"), (5000).to_bytes(4, "little")), bytearray(raw)
    later[raw.index(b"PK\x01\x02") + 6] = 99  # the version that is needed to unpack the first entry
    for content in (larger, bytes(later)):
        (tmp_path / "a.zip").write_bytes(content)
        with pytest.raises(UnusableInput, match=r"a\.zip .*is no file of `drivegen weights save`"):
            unpack(tmp_path / "a.zip", tmp_path / "there")
    assert not (tmp_path / "there").exists()


def test_models_that_are_there_are_not_replaced(models, tmp_path):
    pack(models, tmp_path / "a.zip")
    with pytest.raises(UnusableInput, match="not empty"):
        unpack(tmp_path / "a.zip", models)


def test_a_folder_without_models_is_not_packed(tmp_path):
    with pytest.raises(MissingTool, match="holds no trained models"):
        pack(tmp_path, tmp_path / "a.zip")
