"""A driver in one of its versions: by its name, with what differs from its usual settings; or a mutated one."""

from collections.abc import Mapping
from typing import Any

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import build
from drivegen.drivers.base import Driver
from drivegen.drivers.mutants.table import Mutant


def version(said: Mapping[str, Any], usual: Mapping[str, Mapping[str, Any]], section: str, place: str) -> Driver:
    """The driver that `said`, one name with settings, describes; those it does not name are the `usual` ones of `section`.

    The name may be one of the mutated drivers of `drivers/mutants`. Raises UnusableInput, naming `place`, where it is not one
    name with settings or the driver has no such settings, and as `plugins.make` does.
    """
    if len(said) != 1 or not all(changes is None or isinstance(changes, Mapping) for changes in said.values()):
        raise UnusableInput(f"{place} must be a driver's name with what differs in its settings, as in `idm: {{headway: 1.2}}`")
    (name, changes), *_ = said.items()
    base, dot, _ = str(name).partition(".")
    sound = base if dot and base in usual else str(name)
    if sound in usual and changes:
        plugin = plugins.load("drivers", sound)
        driver: Driver = plugin(build(plugin.settings_type, {**usual[sound], **changes}, f"{place}: {sound}"))
    else:
        driver = plugins.make("drivers", sound, usual, section)
    return driver if sound == name else Mutant(name, driver)
