"""Reading params.yaml; what is wrong inside a section is tried in tests/stages/test_stages_door.py."""

from collections.abc import Iterator
from dataclasses import dataclass, field, is_dataclass
from pathlib import Path
from typing import get_type_hints

import pytest
import yaml

from drivegen.core import plugins
from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.settings import Count, Index, NotNegative, Positive, Share, read_params, read_section, read_tree
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.ingest.selection import Settings as SelectionSettings
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.planners.route_fm import RouteFmSettings
from drivegen.selectors.learned import Settings as SelectorSettings
from drivegen.sumo.corpus import CorpusSettings


def test_a_dotted_section_is_what_stands_there(tmp_path: Path):
    (tmp_path / "p.yaml").write_text("a: {b: {c: 3}, empty: }\n")
    assert read_section("a.b", tmp_path / "p.yaml") == {"c": 3}
    assert read_section("a.empty", tmp_path / "p.yaml") == {}


@pytest.mark.parametrize(
    ("content", "sentence"),
    [(b"a: [", "is not YAML"), (b"\xff\xfe\x00", "is not YAML"), (b"", "has no sections"), (b"- a", "has no sections"),
     (b"a:\n  b: 1\n  c: 2\n  b: 3", "'b' is there twice, again in line 4"),
     (b"\na: {b: c\nd: e}\n", "is not YAML: did not find expected ',' or '}' in line 3"),
     (b"a: 1\n? [b]\n: c\n", "is not YAML: the name in line 2 is a list"),
     (b"a: 2026-13-45", "is not YAML: month must be in 1..12"),
     (b"b: 1", "has no section 'a.b'"), (b"a: 1", "has no section 'a.b'")],
)  # fmt: skip
def test_a_file_that_holds_no_such_section_is_refused(tmp_path: Path, content: bytes, sentence: str):
    (tmp_path / "p.yaml").write_bytes(content)
    with pytest.raises(UnusableInput, match=sentence):
        read_section("a.b", tmp_path / "p.yaml")


def test_without_the_file_it_is_said_where_to_be(tmp_path: Path):
    with pytest.raises(MissingTool, match="the project's folder"):
        read_section("a", tmp_path / "p.yaml")


@dataclass(frozen=True)
class Numbers:
    """One of each kind of bounds."""

    count: Count = 1
    index: Index = 0
    positive: Positive | None = 1.0
    not_negative: NotNegative = 0.0
    share: Share = 1.0
    pairs: dict[str, list[float]] = field(default_factory=dict)


def read(tmp_path: Path, **change: object) -> Numbers:
    """The section `a` of a file in which some numbers are other ones."""
    values = {"count": 1, "index": 0, "positive": None, "not_negative": 0, "share": 1, "pairs": {"x": [1.0]}, **change}
    (tmp_path / "p.yaml").write_text(yaml.safe_dump({"run": {"seed": 7}, "a": values}))
    return read_params("a", Numbers, tmp_path / "p.yaml")


def test_numbers_at_their_bounds_are_taken_and_none_where_it_is_allowed(tmp_path: Path):
    assert read(tmp_path) == Numbers(positive=None, pairs={"x": [1.0]})
    assert read(tmp_path, positive=1e-9).positive == 1e-9


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"count": 0}, "a.count must be at least 1, not 0"),
        ({"index": -1}, "a.index must be at least 0, not -1"),
        ({"positive": 0}, "a.positive must be above 0, not 0.0"),
        ({"not_negative": -0.5}, "a.not_negative must be at least 0, not -0.5"),
        ({"share": 1.5}, "a.share must be between 0 and 1, not 1.5"),
        ({"share": float("nan")}, "a.share must be a finite number, not nan"),
        ({"positive": float("inf")}, "a.positive must be a finite number, not inf"),
        ({"count": True}, "a.count must be int, not True"),
        ({"pairs": [1]}, r"a.pairs must be names and values, not \[1\]"),
        ({"pairs": {"x": "y"}}, "a.pairs.x must be a list, not 'y'"),
        ({"pairs": {"x": [1, "y"]}}, r"a.pairs.x\[1\] must be float, not 'y'"),
    ],
)
def test_what_cannot_be_is_named_with_its_place_before_anything_is_computed(tmp_path: Path, change: dict, sentence: str):
    with pytest.raises(UnusableInput, match=sentence):
        read(tmp_path, **change)


@pytest.mark.parametrize("section", ["[]", "7", "a word"])
def test_a_section_that_is_no_mapping_is_refused(tmp_path: Path, section: str):
    (tmp_path / "p.yaml").write_text(f"run: {section}\na: {section}\n")
    with pytest.raises(UnusableInput, match="must have names and values"):
        read_params("a", Numbers, tmp_path / "p.yaml")


def test_the_numbers_of_this_project_keep_their_bounds():
    params = Path(__file__).parents[2] / "params.yaml"
    assert read_params("place.initial", InitialSettings, params).horizon == 100
    assert read_params("ship.generation", GeneratorSettings, params).temperature > 0
    assert read_params("ingest.selection", SelectionSettings, params).map_radius == 100
    training = read_params("train_planner.planners.route_fm", RouteFmSettings, params).training
    assert training.warmup < training.steps
    assert read_section("maps.prompts", params)["grid"].startswith("a 3 by 3 grid")
    assert read_params("corpus.settings", CorpusSettings, params).window.moving_share <= 1


def numbers_without_bounds(settings: type, place: str) -> Iterator[str]:
    """Fields that are any int or float at all, those of nested settings among them."""
    for name, kind in get_type_hints(settings, include_extras=True).items():
        if kind in (int, float):
            yield f"{place}.{name}"
        elif isinstance(kind, type) and is_dataclass(kind):
            yield from numbers_without_bounds(kind, f"{place}.{name}")


def test_every_number_of_a_model_that_learns_has_bounds():
    """A temperature of 0 would be taken without a word, and all futures of a scene would be the same."""
    models = {
        f"{folder}.{name}": plugins.load(folder, name) for folder in ("generators", "planners") for name in plugins.names(folder)
    }
    settings = {name: plugin.Settings for name, plugin in models.items() if hasattr(plugin, "Settings")}
    assert {"generators.lctgen", "planners.route_fm"} <= set(settings)
    settings["selectors.learned"] = SelectorSettings
    assert [field for name, each in settings.items() for field in numbers_without_bounds(each, name)] == []


@dataclass(frozen=True)
class Nested:
    names: dict[str, int]


def test_a_file_may_stand_for_names_and_values_and_is_named_where_it_is_not_there(tmp_path: Path):
    (tmp_path / "names.yaml").write_text("one: 1\ntwo: 2\n")
    tree = {"run": {}, "a": {"names": str(tmp_path / "names.yaml")}, "b": {"names": {"one": 1}}, "c": {"names": "no.yaml"}}
    (tmp_path / "p.yaml").write_text(yaml.safe_dump(tree))
    assert read_params("a", Nested, tmp_path / "p.yaml").names == {"one": 1, "two": 2}
    assert read_section("a.names", tmp_path / "p.yaml") == {"one": 1, "two": 2}
    assert read_params("b", Nested, tmp_path / "p.yaml").names == {"one": 1}
    with pytest.raises(MissingTool, match=r"no\.yaml is not here"):
        read_params("c", Nested, tmp_path / "p.yaml")


def test_a_model_is_trained_as_all_are_where_its_own_section_says_nothing_else(tmp_path: Path):
    own = {"b": {"training": {"batch": 4, "steps": 2}}, "training": [1]}
    (tmp_path / "p.yaml").write_text(yaml.safe_dump({"run": {}, "training": {"batch": 8, "clip": 1.0}, "a": own}))
    assert read_section("a.b.training", tmp_path / "p.yaml") == {"batch": 4, "clip": 1.0, "steps": 2}
    assert read_section("a", tmp_path / "p.yaml")["training"] == [1]


@pytest.fixture
def two_files(tmp_path: Path):
    """Writes params.yaml and, beside it, that of the stages that only measure us; returns the first."""
    (tmp_path / "stages").mkdir()

    def write(params: str, measures: str) -> Path:
        (tmp_path / "params.yaml").write_text(params)
        (tmp_path / "stages/params.yaml").write_text(measures)
        return tmp_path / "params.yaml"

    return write


def test_a_section_that_is_like_another_one_has_its_values_but_for_those_named_beside_it(two_files):
    path = two_files("a: {x: 1, deep: {y: 2, z: 3}}\nrun: {}\n", "b: {like: a, deep: {z: 4}}\nc: {d: {like: b, x: 5}}\n")
    assert read_section("b", path) == {"x": 1, "deep": {"y": 2, "z": 4}}
    assert read_section("c.d", path) == {"x": 5, "deep": {"y": 2, "z": 4}}
    assert list(read_section("c.d", path)) == [
        "x",
        "deep",
    ]  # in the order of the first
    assert read_section("a", path)["deep"] == {"y": 2, "z": 3}


@pytest.mark.parametrize(
    ("params", "measures", "sentence"),
    [
        ("a: {like: b}", "b: {like: a}", "is like itself"),
        ("a: {b: {like: a}}", "", "a is like itself"),
        ("a: {like: c.d}", "", r"has no section 'c\.d'"),
        ("a: {}", "a: {}", r"'a' is a section of .*params\.yaml and, again, of .*stages/params\.yaml"),
    ],
)
def test_sections_that_are_alike_in_circles_or_twice_there_are_refused(two_files, params: str, measures: str, sentence: str):
    with pytest.raises(UnusableInput, match=sentence):
        read_section("a", two_files(params, measures or "e: {}"))


def test_a_section_that_is_like_nothing_hinders_no_other(two_files):
    path = two_files("a: {x: 1}", "b: {like: gone}\nc: {like: a}")
    assert read_section("a", path) == read_section("c", path) == {"x": 1}
    assert read_tree(path) == {"a": {"x": 1}, "b": {"like": "gone"}, "c": {"x": 1}}
    with pytest.raises(UnusableInput, match="has no section 'gone'"):
        read_section("b", path)


def test_what_is_wrong_is_named_with_the_file_that_it_stands_in(two_files):
    path = two_files("run: {}", "a: {count: 0, index: 0, positive: 1, not_negative: 0, share: 1, pairs: {}}")
    with pytest.raises(UnusableInput, match=r"stages/params\.yaml: a\.count must be at least 1"):
        read_params("a", Numbers, path)


@pytest.mark.parametrize(
    ("place", "value", "sentence"),
    [
        ("candidates.dynamics.braking", 0, "dynamics.braking must be above 0"),
        ("candidates.spacing", 0, "candidates.spacing must be between 0.1 and 100"),
        ("temperature", -1, "generation.temperature must be at least 0.01"),
    ],
)
def test_nested_numbers_are_told_with_their_whole_place(tmp_path: Path, place: str, value: float, sentence: str):
    whole = yaml.safe_load((Path(__file__).parents[2] / "params.yaml").read_text())
    *way, name = place.split(".")
    section = whole["ship"]["generation"]
    for word in way:
        section = section[word]
    section[name] = value
    (tmp_path / "p.yaml").write_text(yaml.safe_dump(whole))
    with pytest.raises(UnusableInput, match=sentence):
        read_params("ship.generation", GeneratorSettings, tmp_path / "p.yaml")
