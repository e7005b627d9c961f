"""The house: few doors at the top, no private module read from outside, no circle of rooms, and a room is a dependency."""

import shutil
from functools import cache
from pathlib import Path

import grimp
import networkx as nx
import pytest
from dvc.repo import Repo

ROOT = Path(__file__).parents[2]
MOST_MODULES, MOST_FOLDERS, MOST_NODES = 6, 8, 25


@cache
def graph() -> grimp.ImportGraph:
    return grimp.build_graph("drivegen", "stages", cache_dir=None)


def edges() -> list[tuple[str, str]]:
    return [(a, b) for a in graph().modules for b in graph().find_modules_directly_imported_by(a)]


def test_few_modules_stand_at_the_top_and_each_is_for_users():
    assert len([path for path in (ROOT / "drivegen").glob("*.py") if path.name != "__init__.py"]) <= MOST_MODULES


def test_a_private_module_is_imported_in_its_own_package_only():
    def owner(module: str) -> str:
        parts = module.split(".")
        return ".".join(parts[: next(i for i, part in enumerate(parts) if part.startswith("_"))])

    private = [(a, b) for a, b in edges() if any(part.startswith("_") for part in b.split(".")) and not b.startswith("stages")]
    assert [f"{a} imports {b}" for a, b in private if not f"{a}.".startswith(f"{owner(b)}.")] == []


def test_rooms_make_no_circle():
    rooms = nx.DiGraph(
        {
            (a.split(".")[1], b.split(".")[1])
            for a, b in edges()
            if a.count(".") and b.count(".") and b.startswith("drivegen") and a.startswith("drivegen")
        }
    )
    rooms.remove_edges_from([(a, a) for a in rooms])
    assert list(nx.simple_cycles(rooms)) == []


def test_a_stage_lists_few_folders_of_code_and_the_pipeline_has_few_stages():
    with Repo(str(ROOT)) as repo:
        stages = repo.index.stages
    folders = {s.addressing: [d for d in listed(s) if not Path(d).suffix] for s in stages if s.path_in_repo == "dvc.yaml"}
    assert {name: len(code) for name, code in folders.items() if len(code) > MOST_FOLDERS and name not in WIDE} == {}
    assert len({name.split("@")[0] for name in folders}) <= MOST_NODES


ALL: set[str] = set()
"""Stands for every stage."""

LEARNERS = frozenset({"train_selector", "train_planner", "train_generator"})
PLANNING = frozenset(
    {
        "rollout", "ship", "corner", "asked", "attack", "beset", "mutation_score", "rates", "recall", "repair",
        "tune", "tune_amounts", "tune_traffic",
    }
)  # fmt: skip
"""Stages in which the planner plans."""

EDITS = {
    "a word": ("drivegen/words/read.py", {"maps", "map_suite", "asked"}),
    "a colour": ("drivegen/render/marks.py", {"maps", "goals", "record", "corner", "report"}),
    "the checker": (
        "drivegen/checker/road.py",
        {"calibrate", "train_planner", "rollout_rival", "rollout_baseline", "additions", *PLANNING},
    ),
    "a rival": (
        "drivegen/generators/bits.py",
        {"train_generator", "rollout_rival", "initial_states", "record", "collect", "report", "tune_traffic"},
    ),
    "geometry": ("drivegen/core/geometry.py", ALL),
    "the training loop": (
        "drivegen/training/loop.py",
        {
            *LEARNERS,
            *PLANNING,
            "goals",
            "rollout_rival",
            "initial_states",
            "rank",
            "tune",
            "drive_tuned",
            "gate",
            "transfer",
            "survival",
            "naturalness",
        },
    ),
    "a planner": ("drivegen/planners/poly_fm.py", {*PLANNING, "report"}),
    "the question to a model": ("drivegen/questions/goals.py", {"goals", "corner"}),
    "a view of the results": ("drivegen/warehouse/sql/schema.sql", {"collect", "report"}),
    "the page": ("drivegen/report/page.py", {"collect", "report"}),
    "the placement": ("drivegen/placement/slots.py", {"assets", "place", "initial_states", "asked", "beset", "tune_traffic"}),
    "the recordings": ("drivegen/recording/roads.py", {"record"}),
}
"""What is edited, in which file, and which stages have to run again for it (with those that follow if their inputs change)."""

WIDE = {"corner@0", "corner@1", "corner@2", "attack@idm", "attack@gail", "attack@sac"}
"""Stages that list more: to generate takes eight folders, and both drive what they generated, shard by shard in one process; a
round of corner cases also asks and draws."""


def listed(stage) -> list[str]:
    return [dep.def_path for dep in stage.deps if dep.def_path.startswith("drivegen")]


def code_hashes(root: Path) -> dict[str, dict[str, str]]:
    """DVC's own hash of every code dependency of every stage; what several depend on is hashed once."""
    with Repo(str(root)) as repo:
        code = {dep.def_path: dep for stage in repo.index.stages for dep in stage.deps if dep.def_path.startswith("drivegen")}
        hashes = {path: str(dep.get_hash()) for path, dep in code.items()}
        return {stage.name: {path: hashes[path] for path in listed(stage)} for stage in repo.index.stages}


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("house")
    for name in ("drivegen", "stages"):
        shutil.copytree(ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("dvc.yaml", "params.yaml", ".dvcignore"):
        shutil.copy(ROOT / name, root)
    (root / ".dvc").mkdir()
    (root / ".dvc" / "config").write_text("[core]\n    no_scm = true\n")
    return root


@pytest.fixture(scope="module")
def before(copy) -> dict[str, dict[str, str]]:
    """Of the copy as it is: every test leaves it so."""
    return code_hashes(copy)


@pytest.mark.parametrize("what", EDITS)
def test_an_edit_makes_the_stages_stale_that_it_concerns_and_no_others(copy, before, what):
    name, expected = EDITS[what]
    content = (copy / name).read_text()
    (copy / name).write_text(content + "\n")
    after = code_hashes(copy)
    (copy / name).write_text(content)
    stale = {stage.split("@")[0] for stage, hashes in after.items() if hashes != before[stage]}
    assert stale == (expected or {stage.split("@")[0] for stage in before})


def test_a_rival_of_its_own_is_trained_again_alone(copy, before):
    file = copy / "drivegen/generators/bits.py"
    content = file.read_text()
    file.write_text(content + "\n")
    after = code_hashes(copy)
    file.write_text(content)
    stale = {stage for stage, hashes in after.items() if hashes != before[stage]}
    assert {stage for stage in stale if stage.startswith(("train_generator", "rollout_rival"))} == {
        "train_generator@bits",
        "rollout_rival@bits",
    }
