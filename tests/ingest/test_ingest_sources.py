"""What the hash of settings and code is of: everything that decides how a recording becomes a row."""

from pathlib import Path

import grimp

import drivegen
from drivegen.ingest import sources
from drivegen.ingest.selection import Settings
from drivegen.ingest.sources import Sources, code_files

PACKAGE = Path(drivegen.__file__).parent
FILES_ONLY = {"store/files.py", "store/notes.py"}
"""How files are written whole, and what is noted of them: no row depends on it."""


def needed() -> set[str]:
    """Modules that turn recordings into shards, with all that they import, as paths below drivegen/."""
    graph = grimp.build_graph("drivegen", cache_dir=None)
    readers = {module for module in graph.modules if module.startswith(("drivegen.datasets.", "drivegen.ingest."))}
    modules = readers.union(*(graph.find_upstream_modules(module) for module in readers))
    names = {"/".join(module.split(".")[1:]) for module in modules}
    return {f"{name}.py" for name in names if (PACKAGE / f"{name}.py").exists()}


def test_all_code_that_decides_is_hashed():
    hashed = {str(path.relative_to(PACKAGE)) for path in code_files()}
    assert needed() - hashed == FILES_ONLY


def test_every_pattern_of_code_finds_files():
    assert [pattern for pattern in sources.CODE if not list(PACKAGE.glob(pattern))] == []


def test_the_hash_follows_settings_and_not_folders():
    selection = Settings(target="focal", max_vehicles=5, first_step=0, horizon=15, map_radius=None, smallest_shrink=0.8)
    here = Sources({"argoverse2": Path("here")}, selection, {})
    assert here.digest() == Sources({"argoverse2": Path("there")}, selection, {}).digest()
    assert here.digest() != Sources(here.folders, selection, {"argoverse2": 12}).digest()
