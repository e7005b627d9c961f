"""Which scenes of which data sets make up our train, val and test splits.

Models learn from `train` and are chosen on `val`; `test` is regenerated and measured on. A source that nobody trained on
is test data as a whole; of one that is trained on, only its held-out split is.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import group_of
from drivegen.core.scenario import SPLITS
from drivegen.core.seeds import derive
from drivegen.datasets.base import Dataset, id_of
from drivegen.ingest.admission import usable_tracks
from drivegen.ingest.selection import Settings

CORPUS = "sumo_corpus"
"""The data set that is always there: models learn from it where there is too little else."""

VAL_SHARE = 20
"""One in so many training recordings is held back for validation where a source's own val split is our test split."""

Opened = Callable[[str], Dataset]
"""Gives a data set by its name, opened."""


@dataclass(frozen=True)
class Plan:
    """What is trained on, what is measured on.

    Attributes:
        source: the data set that is measured on.
        train_on: the data sets that models learn from.
        held_out: the split of each data set, "val" or "test", that is measured on where the data set is trained on.
        limits: at most so many scenes per split of ours; None for all.
        recordings: how the names of those of the source begin that are measured on; all, where none is named.
    """

    source: str
    train_on: tuple[str, ...]
    held_out: dict[str, str]
    limits: dict[str, int | None]
    recordings: tuple[str, ...]


def trained_on(
    sources: tuple[str, ...], opened: Opened, selected: Callable[[str], Settings], fewest: int
) -> tuple[tuple[str, ...], str]:
    """The data sets to train on, and a sentence where that is not what was asked for.

    A data set with fewer than `fewest` usable training tracks, `selected` as its name says, is left out; if nothing remains,
    the corpus steps in.
    """
    names, notes = [], []
    for name in sources:
        if name != CORPUS and (tracks := usable_tracks(opened(name), selected(name), fewest)) < fewest:
            notes.append(f"{name} has {tracks} usable training tracks, fewer than {fewest}: not trained on")
        else:
            names.append(name)
    return tuple(names or [CORPUS]), "; ".join(notes)


def items(plan: Plan, opened: Opened, split: str) -> list[str]:
    """Items `<data set>/<its split>/<scene>` of one of our splits; where there are too many, drawn by a fixed hash.

    Raises UnusableInput where `held_out` does not speak of a data set that is trained on.
    """
    if split == "test":
        theirs = (_held_out(plan, plan.source),) if plan.source in plan.train_on else SPLITS
        scenes = ((word, scene) for word in theirs for scene in opened(plan.source).scenes(word))
        chosen = [f"{plan.source}/{word}/{scene}" for word, scene in scenes if scene.startswith(plan.recordings or "")]
    else:
        chosen = [item for name in plan.train_on for item in _training_items(plan, opened(name), name, split)]
    limit = plan.limits.get(split)
    return chosen if limit is None else sorted(sorted(chosen, key=lambda item: derive(0, "limit", item))[:limit])


def unseen(chosen: Mapping[str, Sequence[str]]) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """By split: the items to keep, and those of train and val that show the same cars as the test split."""
    tested = {_recording(item.split("/", 2)[2]) for item in chosen["test"]}
    kept, shown = ({split: list[str]() for split in chosen} for _ in range(2))
    for split, names in chosen.items():
        for item in names:
            (shown if split != "test" and _recording(item.split("/", 2)[2]) in tested else kept)[split].append(item)
    return kept, shown


def once(chosen: Mapping[str, Sequence[str]]) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """By split: the items whose scenario has an id of its own or has it first, and the others."""
    first, again = ({split: list[str]() for split in chosen} for _ in range(2))
    seen: set[str] = set()
    for split, names in chosen.items():
        for item in names:
            name = id_of(item.split("/", 2)[2])
            (again if name in seen else first)[split].append(item)
            seen.add(name)
    return first, again


def _training_items(plan: Plan, data: Dataset, name: str, split: str) -> list[str]:
    """Its own train or val split; where val is held out as our test split, a share of train stands in for val."""
    if name != plan.source or _held_out(plan, name) != "val":
        return [f"{name}/{split}/{scene}" for scene in data.scenes(split)]
    scenes = data.scenes("train")
    of = {scene: _recording(scene) for scene in scenes}
    held_back = _held_back(set(of.values()))
    return [f"{name}/train/{scene}" for scene in scenes if (of[scene] in held_back) == (split == "val")]


def _held_back(recordings: set[str]) -> set[str]:
    """One in `VAL_SHARE` by a fixed hash; of few recordings (but more than one) the one that comes first by it."""
    numbers = {name: derive(0, "val", name) for name in recordings}
    names = {name for name, number in numbers.items() if number % VAL_SHARE == 0}
    return names or ({min(numbers, key=lambda name: (numbers[name], name))} if len(numbers) > 1 else set())


def _recording(scene: str) -> str:
    """Scenes of one recording, called `<recording>:<number>`, stay together, and those of recordings that show the same cars."""
    return group_of(scene.partition(":")[0])


def _held_out(plan: Plan, name: str) -> str:
    if plan.held_out.get(name) not in ("val", "test"):
        raise UnusableInput(f"ingest.held_out must say of {name!r} whether 'val' or 'test' is measured on")
    return plan.held_out[name]
