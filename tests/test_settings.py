"""Reading params.yaml; what is wrong inside a section is tried in tests/stages/test_stages_door.py."""

from pathlib import Path

import pytest

from drivegen.errors import MissingTool, UnusableInput
from drivegen.settings import read_section


def test_a_dotted_section_is_what_stands_there(tmp_path: Path):
    (tmp_path / "p.yaml").write_text("a: {b: {c: 3}, empty: }\n")
    assert read_section("a.b", tmp_path / "p.yaml") == {"c": 3}
    assert read_section("a.empty", tmp_path / "p.yaml") == {}


@pytest.mark.parametrize(
    ("content", "sentence"),
    [(b"a: [", "is not YAML"), (b"\xff\xfe\x00", "is not YAML"), (b"", "has no sections"), (b"- a", "has no sections"),
     (b"b: 1", "has no section 'a.b'"), (b"a: 1", "has no section 'a.b'")],
)  # fmt: skip
def test_a_file_that_holds_no_such_section_is_refused(tmp_path: Path, content: bytes, sentence: str):
    (tmp_path / "p.yaml").write_bytes(content)
    with pytest.raises(UnusableInput, match=sentence):
        read_section("a.b", tmp_path / "p.yaml")


def test_without_the_file_it_is_said_where_to_be(tmp_path: Path):
    with pytest.raises(MissingTool, match="the project's folder"):
        read_section("a", tmp_path / "p.yaml")
