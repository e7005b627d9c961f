"""What was trained, how large it is, how long it took and whether more would help: every seed, DriveGen beside its rivals."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from drivegen.core.methods import LEARNED, Method
from drivegen.report import plots
from drivegen.report.sections.generators import PLATEAU_NOTE, TEMPERATURE_NOTE, tempered, yes_no
from drivegen.report.table import Cell, Row, Table, number, row, taken
from drivegen.warehouse.runs import Model

OURS = {"train_planner/route_fm": "DriveGen: planner", "train_selector/train_selector": "DriveGen: goal selector"}
"""DriveGen's two models."""

_TUNING = (
    "Not in these seconds: what was tried by hand on validation scenes before. That was much more for DriveGen (temperature, "
    "tempo and spacing of its goals, once for all runs; its selector's features) than for rivals, whose sizes and rates follow "
    "their papers, reduced, and were changed only where they did not learn. A rival's temperature is chosen in its own stage."
)


@dataclass(frozen=True)
class Trained:
    """A model of one training seed; `trained_on` is the data in words.

    `lists`: CPU-seconds of stage goal_lists in the same run, whose output all seeds share; None where it did not run there.
    """

    trained_on: str
    seed: int
    model: Model
    lists: float | None = None


def models(trained: Sequence[Trained], about: Mapping[str, Method]) -> list[Table]:
    """One table with curves for each data that models were trained on; `about` is every generator in the tables' order."""
    sources = dict.fromkeys(one.trained_on for one in trained)
    return [_models(source, [one for one in trained if one.trained_on == source], about) for source in sources]


def _models(source: str, trained: list[Trained], about: Mapping[str, Method]) -> Table:
    titles = OURS | {f"train_generator/{name}": method.title for name, method in about.items()}
    groups = _by_name(trained, titles)
    lines = [_line(titles.get(name, name), group) for name, group in groups.items()]
    mine = [groups[name] for name in OURS if name in groups]
    if len(mine) == len(OURS):
        lines.insert(len(OURS), _together(mine))
    seeds = ", ".join(map(str, sorted({one.seed for one in trained})))
    notes = (
        f"Where there are several numbers, they are of training seeds {seeds}. Parameters: all numbers in the weights' files.",
        PLATEAU_NOTE,
        TEMPERATURE_NOTE,
        "CPU-seconds are of one machine and of one run: another one has others.",
        *filter(None, [_budget(groups, about)]),
        _TUNING,
    )
    columns = ("", "parameters", "steps", "CPU-s of the whole stage", "CPU-s of training alone", "plateau", "temperature")
    title = f"What was trained on {source}: size, time, and whether more training would help"
    curves = {
        titles.get(name, name): {
            f"seed {one.seed}": (one.model.curve["step"], one.model.curve["validation"]) for one in group if one.model.curve
        }
        for name, group in groups.items()
    }
    return Table(
        f"models-{_slug(source)}", title, columns, tuple(lines), notes, picture=plots.panels(curves, "steps", "validation")
    )


def _by_name(trained: list[Trained], first: Iterable[str]) -> dict[str, list[Trained]]:
    """Models by name, those of `first` in their order, each with its seeds in order."""
    names = dict.fromkeys([*first, *sorted(one.model.name for one in trained)])
    groups = {name: sorted((one for one in trained if one.model.name == name), key=lambda one: one.seed) for name in names}
    return {name: group for name, group in groups.items() if group}


def _line(text: str, group: list[Trained]) -> Row:
    return row(
        text,
        _each([number(one.model.parameters) for one in group]),
        _each([number(int(one.model.curve["step"][-1])) if one.model.curve.get("step") else "–" for one in group]),
        _each([taken(one.model.took, "cpu_seconds", 0) for one in group]),
        _each(
            [
                taken(one.model.took, "training_cpu_seconds", 0) if "training_cpu_seconds" in one.model.took else "–"
                for one in group
            ]
        ),
        Cell(_each([yes_no(one.model.plateau) for one in group])),
        Cell(_each([tempered(one.model.temperature) for one in group])),
        origin="ours",
    )


def _together(mine: list[list[Trained]]) -> Row:
    """DriveGen's models in one row: sums."""
    sizes = [group[0].model.parameters for group in mine]
    size = number(sum(counted)) if len(counted := [s for s in sizes if s is not None]) == len(mine) else number(None)
    took = _whole(mine)
    return row(
        "DriveGen, together", size, "–", _each([number(t, 0) for t in took]) if took else "–", "–", "–", "–", origin="ours"
    )


def _whole(mine: list[list[Trained]]) -> list[float]:
    """CPU-seconds of all stages of one method, a seed each; nothing where one was not timed."""
    if not all(one.model.took.get("cpu_seconds") for group in mine for one in group) or len({len(group) for group in mine}) != 1:
        return []
    return [sum(one.model.took["cpu_seconds"] for one in seeds) for seeds in zip(*mine, strict=True)]


def _budget(groups: Mapping[str, list[Trained]], about: Mapping[str, Method]) -> str:
    """Who trained for how long, from what the stages took."""
    ours = _whole([groups[name] for name in OURS if name in groups])
    learned = [f"train_generator/{name}" for name, method in about.items() if method.kind == LEARNED]
    rivals = [one.model.took.get("cpu_seconds") for name in learned for one in groups.get(name, [])]
    finite = [seconds for seconds in rivals if seconds is not None]
    if not ours or not finite or len(finite) < len(rivals):
        return ""
    lists = max((one.lists for group in groups.values() for one in group if one.lists is not None), default=None)
    shared = "" if lists is None else f", after {lists:.0f} once for the goal lists, which all seeds share"
    return (
        f"Budget: whole stages took {min(finite):.0f} to {max(finite):.0f} CPU-seconds for a rival that learns traffic, and "
        f"{_each([f'{seconds:.0f}' for seconds in ours])} for DriveGen's two models together{shared}. IDM's fit has two numbers."
    )


def _each(texts: Sequence[str]) -> str:
    """The texts, or the one that they all are."""
    return texts[0] if len(set(texts)) == 1 else ", ".join(texts)


def _slug(text: str) -> str:
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split())
