"""What no file of the repository may hold: paths of one machine, unfinished business, more than one can read."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MACHINE = re.compile(r"(?<![\w.])/(work|root|home|Users|mnt|workspace)/\w")
UNFINISHED = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X|raise NotImplemented" r"Error)\b")
LONGEST_FILE = 400
LONGEST_STAGE = 120


def texts() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    kinds = {".py", ".md", ".yaml", ".toml", ".sql", ".jinja", ".txt", ""}
    return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).is_file() and Path(name).suffix in kinds]


@pytest.mark.parametrize("pattern", [MACHINE, UNFINISHED], ids=["machine", "unfinished"])
def test_no_file_holds_what_does_not_belong_there(pattern):
    found = [f"{file.relative_to(ROOT)}: {match.group()}" for file in texts() for match in pattern.finditer(file.read_text())]
    assert found == []


def test_files_can_be_read_in_one_sitting():
    lengths = {file.relative_to(ROOT): len(file.read_text().splitlines()) for file in texts() if file.suffix == ".py"}
    doors = {name for name in lengths if name.parts[0] == "stages" and not any(part.startswith("_") for part in name.parts)}
    too_long = {str(name): n for name, n in lengths.items() if n > (LONGEST_STAGE if name in doors else LONGEST_FILE)}
    assert too_long == {}


def test_every_module_says_what_it_is():
    silent = [
        str(file.relative_to(ROOT))
        for file in texts()
        if file.suffix == ".py"
        and "tests" not in file.parts
        and file.read_text().strip()
        and not file.read_text().lstrip().startswith(('"""', 'r"""'))
    ]
    assert silent == []
