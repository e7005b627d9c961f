"""Maps as the command line names them: by their folder or file, and how a language model writes them."""

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

from typer import Option

from drivegen.core.errors import UnusableInput
from drivegen.layouts.spec import MapSpec
from drivegen.maps.build import NETWORK
from drivegen.words.saying import sentences


class Mode(StrEnum):
    """What a language model writes."""

    SPECIFICATION = "specification"
    XML = "xml"


MapMode = Annotated[
    Mode, Option("--map-mode", help="With --lm: the model writes a typed specification, or SUMO XML itself as in the paper.")
]
"""The option `--map-mode`."""


def writer_of(mode: Mode) -> str:
    """The file in drivegen/maps/writers that asks a language model in this mode."""
    return "language_model_xml" if mode is Mode.XML else "language_model"


def network_of(place: Path) -> Path:
    """The SUMO network at `place`: the file itself, or that of a map's folder. Raises UnusableInput where there is none."""
    file = place / NETWORK if place.is_dir() else place
    if not file.is_file():
        raise UnusableInput(f"{file} is not there: `drivegen map` makes maps, give the folder of one or a SUMO network")
    return file


@contextmanager
def with_way_in() -> Iterator[None]:
    """What is no SUMO network is refused with the way to make one of it."""
    try:
        yield
    except UnusableInput as error:
        if error.reason != "wrong-root":
            raise
        raise UnusableInput(f"{error}: bring other formats in with `drivegen map import`", error.reason) from None


def name_of(network: Path) -> str:
    """What scenarios on a network are called after: its file, or its folder where the file is called as in every map."""
    return network.resolve().parent.name if network.name == NETWORK else network.name.split(".")[0]


def sentences_of(account: dict[str, Any]) -> list[str]:
    """A map's specification in plain sentences; none of networks that have no such specification."""
    spec = MapSpec.model_validate(account["spec"]) if account.get("spec") else None
    return [] if spec is None or spec.road.kind == "graph" else sentences(spec)
