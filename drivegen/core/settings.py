"""Settings dataclasses from params.yaml, strictly: nothing unknown, nothing missing, nothing of the wrong type.

Only doors (a stage, the command line) read params.yaml; everything behind them is handed its dataclass. Its sections stand in
two files: those of stages that only measure us in `stages/params.yaml`. `like: SECTION` among names and values stands for
those of that section, in whichever file, but for what is said beside it.
"""

import contextlib
import dataclasses
import math
import types
import typing
from pathlib import Path
from typing import Annotated, Any, TypeVar

import yaml

from drivegen.core.errors import MissingTool, UnusableInput

P = TypeVar("P")

PARAMS = Path("params.yaml")
"""In the project's folder, where every command runs."""

MEASURES = Path("stages/params.yaml")
"""Beside it: the sections of stages that only measure us."""

SHARED = "run"
"""The params section whose keys (seed, workers) every stage may name among its own."""

TRAINING = "training"
"""The params section whose values hold for every model whose own `training` does not name them."""

LIKE = "like"
"""The name beside which stands whose values hold where no others are said."""


@dataclasses.dataclass(frozen=True)
class Within:
    """Bounds of a number in params.yaml, as in `Annotated[int, Within(1)]`; with `above`, `least` itself is too small."""

    least: float
    most: float = math.inf
    above: bool = False

    def __contains__(self, number: float) -> bool:
        return (self.least < number if self.above else self.least <= number) and number <= self.most

    def __str__(self) -> str:
        if math.isfinite(self.most):
            return f"between {self.least:g} and {self.most:g}"
        return f"above {self.least:g}" if self.above else f"at least {self.least:g}"


Count = Annotated[int, Within(1)]
Index = Annotated[int, Within(0)]
Positive = Annotated[float, Within(0, above=True)]
NotNegative = Annotated[float, Within(0)]
Share = Annotated[float, Within(0, 1)]
Seed = Annotated[int, Within(0, 2**63 - 1)]

_SHARED_KINDS = {"seed": Seed, "training_seed": Seed, "sampling_seed": Seed, "workers": Count, "cluster": str}


def read_section(section: str, path: Path = PARAMS) -> dict[str, Any]:
    """The names and values of a section of params.yaml; `section` may be dotted.

    Where names and values are wanted, the name of a YAML file may stand for what is in it. Raises MissingTool where there is
    no such file, UnusableInput where it is no YAML, has no such section, or that is like one that there is not.
    """
    name, tree = section.split(".")[0], _sections(path)
    value = _found(section, {name: _whole(name, tree, path)} if name in tree else {}, path)
    if value is not None and not isinstance(value, dict):
        raise UnusableInput(f"{file_of(section, path)}: {section} must have names and values, not {value!r}")
    return value or {}


def read_params(section: str, params: type[P], path: Path = PARAMS) -> P:
    """The params section as a dataclass; `section` may be dotted. Unknown and missing keys are errors that name both."""
    own_names = {f.name for f in dataclasses.fields(params)}  # type: ignore[arg-type]
    own = read_section(section, path)
    shared = read_section(SHARED, path) if SHARED in _sections(path) else {}
    for name in _SHARED_KINDS.keys() & shared.keys():
        _typed(_SHARED_KINDS[name], shared[name], f"{path}: {SHARED}.{name}")
    return build(params, {**{k: v for k, v in shared.items() if k in own_names}, **own}, f"{file_of(section, path)}: {section}")


def file_of(section: str, path: Path = PARAMS) -> Path:
    """The one of the two files that the section stands in."""
    beside = path.parent / MEASURES
    return beside if beside.exists() and section.split(".")[0] in read_yaml(beside) else path


def build(cls: type[P], values: dict[str, Any], place: str) -> P:
    """A dataclass from a mapping, nested ones too; raises UnusableInput naming the key at fault."""
    fields = {f.name: f for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    hints = typing.get_type_hints(cls, include_extras=True)
    if unknown := sorted(set(map(str, values)) - set(fields)):
        raise UnusableInput(f"{place}: unknown name {unknown[0]!r}; known are {', '.join(sorted(fields))}")
    if missing := sorted(set(fields) - set(values)):
        raise UnusableInput(f"{place}: {missing[0]!r} is missing")
    return cls(**{name: _typed(hints[name], value, f"{place}.{name}") for name, value in values.items()})


def expect_multiple(place: str, number: int, of: int, named: str = "") -> None:
    """Raise UnusableInput unless the parameter `place`, `number`, is a multiple of `of`, which another one, `named`, may say."""
    if number % of:
        raise UnusableInput(f"{place} must be a multiple of {f'{named}, {of}' if named else of}, not {number}")


def _typed(hint: Any, value: Any, place: str) -> Any:
    if hint is Any:  # checked by whoever knows the value's own types
        return value
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    value = _written_out(hint, value)
    if origin is Annotated:
        return _within(_typed(inner[0], value, place), inner[1:], place)
    if origin in (typing.Union, types.UnionType):
        return None if value is None else _typed(next(t for t in inner if t is not type(None)), value, place)
    if dataclasses.is_dataclass(hint) and isinstance(value, dict):
        return build(hint, value, place)  # type: ignore[arg-type]
    if origin in (tuple, list) and isinstance(value, list):
        return origin(_typed(inner[0], v, f"{place}[{i}]") for i, v in enumerate(value))
    if origin is dict and isinstance(value, dict):
        return {k: _typed(inner[1], v, f"{place}.{k}") for k, v in value.items()}
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    kind = origin or hint
    if isinstance(kind, type) and (not isinstance(value, kind) or (kind is int and isinstance(value, bool))):
        raise UnusableInput(f"{place} must be {_IN_WORDS.get(kind, kind.__name__)}, not {value!r}")
    if isinstance(value, float) and not math.isfinite(value):
        raise UnusableInput(f"{place} must be a finite number, not {value!r}")
    return value


_IN_WORDS: dict[Any, str] = {tuple: "a list", list: "a list", dict: "names and values"}


def _within(value: Any, bounds: tuple[Any, ...], place: str) -> Any:
    for bound in bounds:
        if isinstance(bound, Within) and value not in bound:
            raise UnusableInput(f"{place} must be {bound}, not {value!r}")
    return value


class _Loader(yaml.CSafeLoader):
    """Takes no name twice in one section: the first value would be lost without a word."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        names: set[str] = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise yaml.YAMLError(f"the name in line {key.start_mark.line + 1} is a list or has names and values")
            if key.value in names:
                raise yaml.YAMLError(f"{key.value!r} is there twice, again in line {key.start_mark.line + 1}")
            names.add(key.value)
        values: dict[Any, Any] = super().construct_mapping(node, deep)
        return values


def read_tree(path: Path = PARAMS) -> dict[str, Any]:
    """All sections by name. One that is like a section that there is not stands as it is written: whoever reads it is told.

    Raises MissingTool where there is no such file, UnusableInput where it is no YAML or a section stands in both files.
    """
    tree = _sections(path)
    whole = dict(tree)
    for name in tree:
        with contextlib.suppress(UnusableInput):
            whole[name] = _whole(name, tree, path)
    return whole


def read_yaml(path: Path) -> dict[str, Any]:
    """The names and values of any YAML file; raises MissingTool where it is not there, UnusableInput where it has none."""
    if not path.exists():
        raise MissingTool(f"{path} is not here: change into the project's folder, the one with the Makefile")
    try:
        tree = yaml.load(path.read_text(), _Loader)  # noqa: S506 - a safe one
    except (yaml.YAMLError, ValueError) as error:  # a date or a text that cannot be is a ValueError
        raise UnusableInput(f"{path} is not YAML: {_fault(error)}") from None
    if not isinstance(tree, dict):
        raise UnusableInput(f"{path} has no sections")
    values: dict[str, Any] = tree
    return values


def _fault(error: Exception) -> str:
    """What is wrong in a file, with the line where that is known."""
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark:
        return f"{error.problem} in line {error.problem_mark.line + 1}"
    return str(error).splitlines()[0]


def _sections(path: Path) -> dict[str, Any]:
    """What is written in `path` and, where there is one, in the second file."""
    beside = path.parent / MEASURES
    tree, measures = read_yaml(path), read_yaml(beside) if beside.exists() else {}
    if twice := tree.keys() & measures.keys():
        raise UnusableInput(f"{min(twice)!r} is a section of {path} and, again, of {beside}")
    return tree | measures


def _whole(name: str, tree: dict[str, Any], path: Path) -> Any:
    """A section with the values of those that it is like and, in a `training`, those of the section of that name."""
    if name == TRAINING:
        return tree[name]
    return _trained(_alike(tree[name], tree, path, ()), tree.get(TRAINING))


def _found(section: str, tree: Any, path: Path) -> Any:
    """What stands under a dotted name; the file that a name stands for is opened."""
    for word in section.split("."):
        if not isinstance(tree, dict) or word not in tree:
            raise UnusableInput(f"{path} has no section {section!r}")
        tree = _opened(tree[word])
    return tree


def _alike(value: Any, tree: dict[str, Any], path: Path, within: tuple[str, ...]) -> Any:
    """`value` with those of the sections that it is like; `within` are the sections that are being looked up."""
    if not isinstance(value, dict):
        return value
    own = {name: _alike(inner, tree, path, within) for name, inner in value.items() if name != LIKE}
    if LIKE not in value:
        return own
    section = str(value[LIKE])
    if section in within:
        raise UnusableInput(f"{path}: {section} is like itself")
    return _over(_alike(_found(section, tree, path), tree, path, (*within, section)), own)


def _over(base: Any, own: Any) -> Any:
    """`own` values in place of those of `base`, name by name and at every depth."""
    if not isinstance(base, dict) or not isinstance(own, dict):
        return own
    return {**base, **{name: _over(base.get(name), value) for name, value in own.items()}}


def _written_out(hint: Any, value: Any) -> Any:
    """Where names and values are wanted, those in the file that `value` names."""
    return _opened(value) if typing.get_origin(hint) is dict or dataclasses.is_dataclass(hint) else value


def _opened(value: Any) -> Any:
    """What is in a YAML file, where `value` is the name of one."""
    return read_yaml(Path(value)) if isinstance(value, str) and value.endswith(".yaml") else value


def _trained(tree: Any, default: Any) -> Any:
    """`tree` with the values of `default` in every `training` that does not name them."""
    if not isinstance(tree, dict) or not isinstance(default, dict):
        return tree
    return {
        name: {**default, **value} if name == TRAINING and isinstance(value, dict) else _trained(value, default)
        for name, value in tree.items()
    }
