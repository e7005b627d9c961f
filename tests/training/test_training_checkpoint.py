"""What an interrupted training is named after."""

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from drivegen.training.checkpoint import name_of, source_digest

ENTRY = """
import sys
from pathlib import Path
from drivegen.training.checkpoint import source_digest
import learner.loop

print(source_digest("learner"))
for name in sys.argv[1:]:
    with (Path(__file__).parent / name).open("a") as file:
        file.write("# edited\\n")
    print(source_digest("learner"))
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package `learner` with a module that is loaded and one that is not; `digests` runs it with `python -m`."""
    folder = tmp_path / "learner"
    folder.mkdir()
    for name, text in (("__init__", ""), ("entry", ENTRY), ("loop", "RATE = 1\n"), ("other", "RATE = 1\n")):
        (folder / f"{name}.py").write_text(text)
    return folder


def digests(package: Path, *edited: str) -> list[str]:
    """The digest as the package is, and after an edit of each of these files."""
    env = {"PYTHONPATH": f"{package.parent}:{Path(__file__).parents[2]}", "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "learner.entry", *edited]
    done = subprocess.run(command, env=env, cwd=package.parent, capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_the_digest_covers_every_module_that_is_loaded_the_one_that_is_run_included_and_no_other(package: Path) -> None:
    found = digests(package, "other.py", "loop.py", "entry.py", "__init__.py")
    assert len(found[0]) == 64
    assert [a == b for a, b in pairwise(found)] == [True, False, False, False]


def test_the_digest_does_not_depend_on_where_the_package_lies(package: Path, tmp_path: Path) -> None:
    before = digests(package)
    (tmp_path / "elsewhere").mkdir()
    assert digests(package.rename(tmp_path / "elsewhere" / "learner")) == before


def test_what_is_not_of_the_packages_does_not_count() -> None:
    assert source_digest("json") not in (source_digest("json", "subprocess"), source_digest("nothing"))
    assert source_digest("json", "nothing") == source_digest("json")


def test_the_name_changes_with_inputs_files_and_code(tmp_path: Path) -> None:
    shard = tmp_path / "shard"
    shard.write_bytes(b"one")
    names = [
        name_of(("seed", 1), [shard], "code"),
        name_of(("seed", 2), [shard], "code"),
        name_of(("seed", 1), [shard], "edited"),
    ]
    assert name_of(("seed", 1), [shard], "code") == names[0]
    shard.write_bytes(b"two")
    names.append(name_of(("seed", 1), [shard], "code"))
    assert len(set(names)) == 4
