"""A driver as the command line names it."""

from pathlib import Path

from drivegen.core.errors import UnusableInput
from drivegen.core.settings import read_section, read_yaml
from drivegen.drivers.base import Driver
from drivegen.drivers.shared.file import FileDriver
from drivegen.drivers.shared.version import version

SECTION = "attack.drivers"


def driver_of(word: str) -> Driver:
    """The driver of a Python file; or the one that a YAML file describes, with what differs in its settings; or of that name."""
    if word.endswith(".py"):
        return FileDriver(Path(word))
    if word.endswith(".yaml") and not Path(word).is_file():
        raise UnusableInput(f"{word} is no file: give one with a driver's name and settings, or a driver of params.yaml")
    drivers = read_yaml(Path(word)) if word.endswith(".yaml") else {word: {}}
    return version(drivers, read_section(SECTION), SECTION, word)
