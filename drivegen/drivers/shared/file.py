"""A driver that is one Python file with a function `act(observation)`, as `drivers.base.Driver.act`.

The file is run as it is, with the rights of whoever runs DriveGen.
"""

import copy
import importlib.util
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

from drivegen.core.errors import UnusableInput
from drivegen.drivers.shared.answer import checked
from drivegen.world.observation import Action, Observation

_SEE = "see docs/drivers.md"
_PLUGIN = "its `Plugin` needs settings, which params.yaml has by name; copy it into drivegen/drivers and name it without .py"


class FileDriver:
    """Asks the function; `name` is the file's. What goes wrong in it is UnusableInput, in one sentence."""

    settings_type: ClassVar[type] = Path
    sees_rules = True

    def __init__(self, path: Path) -> None:
        """Runs the file. Raises UnusableInput where it cannot be run or has no `act`."""
        self.name, self._path = path.stem, path
        self._file = path.resolve()  # while a relative path still leads there
        self._act: Callable[[Observation], Any] = _function(path)

    def act(self, observation: Observation) -> Action:
        """See `drivers.base.Driver`."""
        try:
            answer = self._act(copy.deepcopy(observation))  # some of it is the world's own state
        except (Exception, SystemExit) as error:  # an exit would count as a finished command
            raise UnusableInput(f"{self._path}: act(observation) fails{_where(error, self._file)}: {_what(error)}") from error
        return checked(answer, str(self._path), observation.speed)


def _function(path: Path) -> Callable[[Observation], Any]:
    spec = importlib.util.spec_from_file_location(f"driver_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise UnusableInput(f"{path} is no Python file: give one with a function act(observation), see docs/drivers.md")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look there for the names in annotations that are kept as text
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[spec.name]
        raise UnusableInput(f"{path} cannot be run: {_what(error)}") from error
    act: Callable[[Observation], Any] | None = getattr(module, "act", None)
    if not callable(act):
        raise UnusableInput(f"{path} has no function act(observation): {_PLUGIN if hasattr(module, 'Plugin') else _SEE}")
    return act


def _what(error: BaseException) -> str:
    return f"{type(error).__name__}, {(str(error) or 'without a word').splitlines()[0]}"


def _where(error: BaseException, file: Path) -> str:
    """The last line of the file itself, a resolved path, that was on the way to the error."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename).resolve() == file]
    return f" in line {lines[-1]}" if lines else ""
