"""A driver as the command line names it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.settings import read_section, read_yaml
from drivegen.drivers.base import Driver
from drivegen.drivers.shared.file import FileDriver
from drivegen.drivers.shared.version import version

SECTION = "attack.drivers"


def driver_of(word: str) -> Driver:
    """The driver of a Python file; or the one that a YAML file describes, with what differs in its settings; or of that name."""
    file = Path(word)
    if file.suffix == ".py":
        return FileDriver(file)
    described = file.suffix in (".yaml", ".yml")
    if described and not file.is_file():
        raise UnusableInput(f"{word} is no file: give one with a driver's name and settings, or a driver of params.yaml")
    usual = read_section(SECTION)
    if described:
        return _described(word, usual)
    if word.partition(".")[0] not in usual and (file.exists() or "/" in word):  # "" is the folder itself
        raise UnusableInput(
            f"{word!r} is no driver: give a Python file (.py), a YAML file with a driver and its settings (.yaml),"
            f" or one of {', '.join(usual)}"
        )
    return version({word: {}}, usual, SECTION, word)


def _described(word: str, usual: Mapping[str, Mapping[str, Any]]) -> Driver:
    """The driver of a YAML file, which every refusal names; so do missing weights, for the file says where they are."""
    try:
        return version(read_yaml(Path(word)), usual, SECTION, word)
    except MissingTool as error:
        raise UnusableInput(f"{word}: {error}, or name the folder of its weights") from None
    except UnusableInput as error:
        raise UnusableInput(str(error) if str(error).startswith(word) else f"{word}: {error}", error.reason) from None
