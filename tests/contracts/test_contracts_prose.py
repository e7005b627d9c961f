"""What no file of the repository may hold: paths of one machine, unfinished business, false names, more than one can read."""

import ast
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from drivegen.core.settings import read_yaml

ROOT = Path(__file__).parents[2]
MACHINE = re.compile(r"(?<![\w.])/(work|root|home|Users|mnt|workspace)/\w")
UNFINISHED = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X|raise NotImplemented" r"Error)\b")
LONGEST_FILE = 400
LONGEST_STAGE = 120
NAMED = re.compile(r"`(_\w+|[a-zA-Z_]\w*(?:\.\w+)+)`")
ELSEWHERE = re.compile(
    r"[\w.]+\.(jsonl?|md|png|safetensors|xml|yaml)|check_map\.py|pyarrow\..+"  # files, code of others
    r"|map\.centreline\.points|(x|key)\.(low|high)|(left_out|shuffled|joint)\.[xN]"  # a column, figures
)


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


def bound(node: ast.Module | ast.ClassDef) -> Iterator[str]:
    """Names that a module or a class binds, attributes that its methods set too."""
    for child in node.body:
        if isinstance(child, ast.FunctionDef | ast.ClassDef):
            yield child.name
        elif isinstance(child, ast.Assign | ast.AnnAssign):
            yield from (each.id for each in ast.walk(child) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store))
    if isinstance(node, ast.ClassDef):
        yield from (each.attr for each in ast.walk(node) if isinstance(each, ast.Attribute) and isinstance(each.ctx, ast.Store))


def defined(file: Path) -> Iterator[str]:
    """A module, what it binds and what its classes bind, `drivegen.room.module.Class.member`, and every end of these names."""
    module = ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    tree = ast.parse(file.read_text())
    names = [module, f"{module}.py", *(f"{module}.{name}" for name in bound(tree))]
    for each in tree.body:
        names += [f"{module}.{each.name}.{name}" for name in bound(each)] if isinstance(each, ast.ClassDef) else []
    for name in names:
        parts = name.split(".")
        yield from (".".join(parts[n:]) for n in range(len(parts) - 1))


def sections(values: object, name: str = "") -> Iterator[str]:
    """Names of all values of a params.yaml: `run.seed`."""
    yield name
    for key, value in values.items() if isinstance(values, dict) else ():
        yield from sections(value, f"{name}.{key}".lstrip("."))


def test_names_in_prose_are_of_what_there_is():
    """`_name` and `a.b` in backticks: of a module, of what is in it, of a section of params.yaml, or of the file's own code."""
    files = {file: file.read_text() for part in ("drivegen", "stages", "flows") for file in (ROOT / part).rglob("*.py")}
    params = [read_yaml(ROOT / name) for name in ("params.yaml", "stages/params.yaml")]
    params.append({"tables": read_yaml(ROOT / "flows/tables.yaml")})
    there = {name for file in files for name in defined(file)}.union(*map(sections, params))
    lost = []
    for file, text in files.items():
        code = NAMED.sub("", text)
        names = {name for name in NAMED.findall(text) if name not in there and not ELSEWHERE.fullmatch(name)}
        lost += [f"{file.relative_to(ROOT)}: {name}" for name in names if not re.search(rf"(?<!\w){re.escape(name)}\b", code)]
    assert sorted(lost) == []
