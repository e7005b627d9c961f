"""How a language model writes maps, as the command line names it."""

from enum import StrEnum
from typing import Annotated

from typer import Option


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
