"""Which runs each part of the published tables is made from, and the door that pools them.

A run is a room: a workspace of its own with parameters that differ from params.yaml. Real recordings are looked for in one
folder; data sets that are not there are left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flows import FlowFailed
from flows.workspace import read_yaml

ROOMS = Path(".drivegen/tables")

QUALITY, MAPS, DRIVERS, CORNER, RATES = PARTS = ("quality", "maps", "drivers", "corner", "rates")
"""The paper's first table; single pieces, maps from words first; drivers; corner cases; how often drivers fail."""

DOORS = {
    QUALITY: ("publish", ROOMS),
    MAPS: ("publish_maps", ROOMS / "pieces"),
    DRIVERS: ("publish_drivers", ROOMS / DRIVERS),
    CORNER: ("publish_corner", ROOMS / CORNER),
    RATES: ("publish_rates", ROOMS / RATES),
}
"""What pools each part, and from where."""

MEASURED = (
    "evaluate", "evaluate_rival", "evaluate_baseline", "additions", "goals", "train_selector", "train_planner", "train_generator",
)  # fmt: skip
"""Stages whose results the first table shows; what they need is run, too."""

FRONT = ("evaluate",)
"""Those of a run at another temperature."""

OF_PIECES = ("map_suite", "map_diversity", "likeness", "initial_states", "asked", "train_planner", "goals")
BY_SEED = {
    CORNER: ("attack", "beset", "mutation_score", "naturalness", "recall", "repair", "survival", "transfer"),
    RATES: ("rates",),
}
"""Parts with a run for every seed."""


@dataclass(frozen=True)
class Room:
    """One run: `<data set>/<what varies>`, the parameters by which it differs from params.yaml, and what is wanted of it."""

    name: str
    params: dict[str, Any]
    measured: tuple[str, ...]


def rooms(part: str, values: dict[str, Any], real: Path) -> list[Room]:
    """The runs of a part, by the `values` of params.yaml and the folder of real recordings.

    Raises FlowFailed, before any of them is run, where something that they need is missing or of another kind.
    """
    try:
        return list(_rooms(part, _opened(values["tables"])[part], real))
    except (KeyError, TypeError, AttributeError) as error:
        fault = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise FlowFailed(f"tables.{part} of params.yaml, or the file named there, can't be used: {fault}") from None


def _rooms(part: str, publish: dict[str, Any], real: Path) -> Iterator[Room]:
    if part == MAPS:
        folder = str(real) if real.is_dir() else ""
        yield Room("pieces", {name: placed(value, folder) for name, value in publish["params"].items()}, OF_PIECES)
    elif part == DRIVERS:
        for name, data, params in _data_sets(publish, real):
            yield Room(f"{DRIVERS}/{name}", params, tuple(data["measured"]))
    elif part in BY_SEED:
        for seed in publish["seeds"]:
            yield Room(f"{part}/{seed}", {**publish["params"], "run.seed": seed}, BY_SEED[part])
    else:
        yield from _of_quality(publish, real)


def left_out(part: str, values: dict[str, Any], real: Path) -> Iterator[Path]:
    """Folders of results that earlier runs of a part have of data sets that are not there now: its door reads all it finds."""
    for name, data in _opened(values["tables"])[part].get("data", {}).items():
        if not _is_there(data, real):
            yield from (DOORS[part][1] / name).glob("*/reports" if part == QUALITY else "reports")


def _of_quality(publish: dict[str, Any], real: Path) -> Iterator[Room]:
    """Every data set that is there with every pair of seeds, then DriveGen alone at other temperatures with the first pair."""
    pairs = [
        {"run.training_seed": trained, "run.sampling_seed": sampling_seed}
        for trained in publish["seeds"]
        for sampling_seed in publish["sampling_seeds"]
    ]
    for name, data, params in _data_sets(publish, real):
        for pair in pairs:
            yield Room(f"{name}/{'-'.join(map(str, pair.values()))}", params | pair, MEASURED)
        for temperature in publish["temperatures"] if data["front"] else ():
            alone = {"run.own": ["drivegen"], "rollout.generation.temperature": temperature}
            yield Room(f"{name}/t{temperature}", params | pairs[0] | alone, FRONT)


def _data_sets(publish: dict[str, Any], real: Path) -> Iterator[tuple[str, dict[str, Any], dict[str, Any]]]:
    """Name, entry and parameters of each data set that is there."""
    for name, data in publish["data"].items():
        if _is_there(data, real):
            folders = {key: placed(value, str(real / data["folder"])) for key, value in data["folders"].items()}
            yield name, data, {**publish["params"], **data["params"], **folders}


def _is_there(data: dict[str, Any], real: Path) -> bool:
    return not data["folder"] or (real / data["folder"]).is_dir()


def _opened(section: Any) -> dict[str, Any]:
    """The values of a section of params.yaml, for which the name of a file may stand."""
    values: dict[str, Any] = read_yaml(Path(section)) if isinstance(section, str) else section
    return values


def placed(value: Any, folder: str) -> Any:
    """`value` with the folder of real recordings wherever it is FOLDER, at any depth."""
    if isinstance(value, dict):
        return {key: placed(item, folder) for key, item in value.items()}
    return folder if value == "FOLDER" else value
