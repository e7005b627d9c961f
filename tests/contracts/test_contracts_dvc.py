"""dvc.yaml tells the truth: what a stage imports are its deps, what it reads from params.yaml are its params.

DVC hashes files and follows no import, so an edit in a module that is not listed would leave a stale result standing.
"""

import dataclasses
import importlib
import inspect
import re
from functools import cache
from pathlib import Path

import grimp
import pytest
from dvc.dependency.param import ParamsDependency
from dvc.repo import Repo

from drivegen.core.errors import UnusableInput
from drivegen.core.settings import read_yaml
from stages import _door

ROOT = Path(__file__).parents[2]
LOADED = re.compile(r"""\b(?:load|make)\(\s*"([\w.]+)",""")
NAMED = re.compile(r"""\bplugins\.names\(\s*"([\w.]+)",""")
UNTRACKED = [str(_door.COST_FOLDER), ".drivegen/calls", "reports/pieces"]
"""Read, but no dep: times differ from run to run, of calls of language models too; single pieces are measured on their own."""


@cache
def imports() -> grimp.ImportGraph:
    return grimp.build_graph("drivegen", "stages", cache_dir=None)


def stages() -> dict[str, list]:
    """Stages of dvc.yaml by the word of their command: the items of a matrix, and of several with the same door, together."""
    found: dict[str, list] = {}
    with Repo(str(ROOT)) as repo:
        for stage in repo.index.stages:
            found.setdefault(stage.cmd.split()[1], []).append(stage)
    return found


STAGES = stages()


def code_deps(stage) -> list[str]:
    return [dep.def_path for dep in stage.deps if dep.def_path.startswith(("drivegen", "stages"))]


def path_of(module: str) -> Path:
    path = ROOT / Path(*module.split("."))
    return path.with_suffix(".py") if path.with_suffix(".py").exists() else path / "__init__.py"


@cache
def source(module: str) -> str:
    return path_of(module).read_text()


@cache
def upstream(module: str) -> set[str]:
    return imports().find_upstream_modules(module)


@cache
def modules_at(path: str) -> set[str]:
    """The modules of a file, or of a folder and all below it."""
    name = path.removesuffix(".py").replace("/", ".")
    return {module for module in imports().modules if module == name or module.startswith(f"{name}.")}


@cache
def needed(stage) -> set[str]:
    """Everything that the stage's module imports, and what those plugins among its deps import that it loads by name."""
    listed = {module for path in code_deps(stage) for module in modules_at(path)}
    start, closure = set(), {f"stages.{stage.cmd.split()[1]}", "stages._door", "stages._door.__main__"}
    while start != closure:
        start = closure
        closure = start.union(*map(upstream, start))
        rooms = {f"drivegen.{folder}" for module in closure for folder in LOADED.findall(source(module))}
        closure |= {module for module in listed if module.rpartition(".")[0] in rooms}
    return {module for module in closure if source(module).strip() and path_of(module).name != "__init__.py"}


def folders_read(stage) -> set[str]:
    """Folders of plugins whose names are listed, or that are asked what they say of themselves: their files are not run."""
    texts = [source(module) for module in needed(stage) if module != "drivegen.core.methods"]
    rooms = {name for text in texts for name in NAMED.findall(text)}
    rooms |= {"generators" for text in texts if "read_methods(" in text}
    return {f"drivegen/{room.replace('.', '/')}" for room in rooms}


@pytest.mark.parametrize("word", STAGES)
def test_the_stage_is_called_like_its_file_and_its_command(word):
    assert (ROOT / "stages" / f"{word}.py").exists()
    for stage in STAGES[word]:
        assert stage.cmd.split()[:2] == ["stages/run", word]
        assert re.fullmatch(rf"{word}(_[a-z]+)?(@.+)?", stage.name)


@pytest.mark.parametrize("word", STAGES)
def test_what_a_stage_imports_is_listed_and_nothing_else(word):
    wanted_by_any = set().union(*(needed(stage) for stage in STAGES[word]))  # plugins of one matrix import different things
    for stage in STAGES[word]:
        listed = {path: modules_at(path) for path in code_deps(stage)}
        missing = sorted(str(path_of(m).relative_to(ROOT)) for m in needed(stage).difference(*listed.values()))
        useless = sorted(
            path
            for path, modules in listed.items()
            if modules and not modules & wanted_by_any and path not in folders_read(stage)
        )
        assert (missing, useless) == ([], []), f"{stage.addressing}: add the first, remove the second"


@pytest.mark.parametrize("word", STAGES)
def test_plugins_that_are_loaded_by_name_are_listed(word):
    """Import graphs do not see them."""
    for stage in STAGES[word]:
        folders = {folder for module in needed(stage) for folder in LOADED.findall(source(module))}
        for folder in folders:
            place = f"drivegen/{folder.replace('.', '/')}"
            chosen = [p for p in code_deps(stage) if f"{place}/".startswith(f"{p}/") or re.fullmatch(rf"{place}/[a-z]\w*\.py", p)]
            assert [p for p in chosen if not p.endswith("/base.py")], f"{stage.addressing}: which {place} does it load?"


@pytest.mark.parametrize("word", STAGES)
def test_folders_of_plugins_that_are_read_and_not_run_are_listed(word):
    for stage in STAGES[word]:
        assert folders_read(stage) - set(code_deps(stage)) == set(), stage.addressing


@pytest.mark.parametrize("word", STAGES)
def test_data_files_that_a_module_reads_from_its_package_are_listed(word):
    for stage in STAGES[word]:
        readers = [path_of(m) for m in needed(stage) if "importlib.resources" in source(m)]
        read = {f for reader in readers for f in reader.parent.rglob("*") if f.is_file() and f.suffix not in (".py", ".pyc")}
        listed = [ROOT / path for path in code_deps(stage)]
        assert [str(f) for f in read if not any(f.is_relative_to(path) for path in listed)] == []


@pytest.mark.parametrize("word", STAGES)
def test_every_path_of_the_command_is_a_dep_or_an_out(word):
    for stage in STAGES[word]:
        known = [*UNTRACKED, *(str(entry.def_path) for entry in [*stage.deps, *stage.outs])]
        for path in stage.cmd.split()[2:]:
            assert any(Path(path).is_relative_to(k) or Path(k).is_relative_to(path) for k in known), (stage.addressing, path)


@pytest.mark.parametrize("word", STAGES)
def test_the_command_has_as_many_paths_as_the_stage_takes(word):
    module = importlib.import_module(f"stages.{word}")
    parameters = inspect.signature(module.main).parameters.values()
    rest = any(each.kind is each.VAR_POSITIONAL for each in parameters)
    fewest = sum(each.default is each.empty and each.kind is not each.VAR_POSITIONAL for each in parameters)
    for stage in STAGES[word]:
        given = 1 + len(stage.cmd.split()[2:])  # the first one is the parameters
        assert fewest <= given <= (given if rest else len(parameters)), stage.addressing


@pytest.mark.parametrize("word", STAGES)
def test_params_are_those_that_the_stage_reads_and_the_file_holds(word):
    module = importlib.import_module(f"stages.{word}")
    params = _door.read_params(word, module.Params, ROOT / "params.yaml")
    own = {field.name for field in dataclasses.fields(module.Params)}
    for stage in STAGES[word]:
        listed = {name for dep in stage.deps if isinstance(dep, ParamsDependency) for name in dep.params}
        shared = {name.removeprefix("run.") for name in listed if name.startswith("run.")}
        assert shared == (own & set(_door.read_section("run"))) - {"workers", *_door.read_section(word)}, stage.addressing
        assert {name.split(".")[0] for name in listed} & {word} or not own - {*shared, "workers"}, (
            f"{stage.addressing}: params must list {word!r}"
        )
    assert params is not None


def likes(value: object) -> set[str]:
    """The sections that names and values are like, those of these sections included."""
    if not isinstance(value, dict):
        return set()
    named = {str(value["like"])} if "like" in value else set()
    within = [*value.values(), *(raw(section) for section in named)]
    return named.union(*map(likes, within))


def raw(section: str) -> object:
    """What stands in a section, as it is written."""
    value: object = {**read_yaml(ROOT / "params.yaml"), **read_yaml(ROOT / "stages/params.yaml")}
    for word in section.split("."):
        assert isinstance(value, dict)
        value = value[word]
    return value


@pytest.mark.parametrize("word", STAGES)
def test_sections_that_those_of_a_stage_are_like_are_listed(word):
    """DVC compares what is written: it does not look up what a section is like."""
    for stage in STAGES[word]:
        listed = {name for dep in stage.deps if isinstance(dep, ParamsDependency) for name in dep.params}
        wanted = set().union(*(likes(raw(name)) for name in listed))
        assert [s for s in sorted(wanted) if not any(f"{s}.".startswith(f"{name}.") for name in listed)] == [], stage.addressing


def test_rounds_depend_on_what_their_driver_drives_by():
    """Of a driver that learned, its weights: the stage refuses others."""
    file = raw("corner.drives_by")
    assert all(file in {dep.def_path for dep in stage.deps} for stage in STAGES["corner"])
    learned = {"driver_settings": {"weights": "data/models/drivers/gail", "sees_rules": True}}
    params = _door.read_params("corner", importlib.import_module("stages.corner").Params, ROOT / "params.yaml")
    with pytest.raises(UnusableInput, match=r"corner\.drives_by must be corner\.driver_settings\.weights"):
        dataclasses.replace(params, **learned)
    assert dataclasses.replace(params, **learned, drives_by="data/models/drivers/gail")


def test_a_section_stands_beside_the_pipeline_that_has_its_stage():
    measured = set(read_yaml(ROOT / "stages/params.yaml"))
    assert measured == {word for word, items in STAGES.items() if {s.path_in_repo for s in items} == {"stages/dvc.yaml"}}


def test_plots_are_drawn_without_a_network():
    with Repo(str(ROOT)) as repo:
        page = Path(repo.dvc_dir) / repo.config["plots"]["html_template"]
    text = page.read_text()
    assert "{plot_divs}" in text
    assert "{scripts}" not in text  # DVC's own: they are fetched from elsewhere
    assert "://" not in text
    assert "function vegaEmbed(" in text


def test_only_the_methods_are_metrics_of_dvc():
    """`dvc metrics show` puts all columns of all files side by side: more of them would not fit on a screen."""
    with Repo(str(ROOT)) as repo:
        shown = {out.def_path for stage in repo.index.stages for out in stage.outs if out.metric}
    assert shown
    assert all(path.startswith("reports/metrics/quality/") for path in shown)
