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
    file = Path(word)
    if file.suffix == ".py":
        return FileDriver(file)
    described = file.suffix in (".yaml", ".yml")
    if described and not file.is_file():
        raise UnusableInput(f"{word} is no file: give one with a driver's name and settings, or a driver of params.yaml")
    drivers = read_yaml(file) if described else {word: {}}
    return version(drivers, read_section(SECTION), SECTION, word)
