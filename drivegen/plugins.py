"""Find a plugin by its name: the file `drivegen/<folder>/<name>.py` is the plugin `<name>`.

Each plugin module exposes `Plugin`, a class (or factory) that the folder's `base.py` describes by a protocol.
Adding one is adding one file; the folder's contract test finds it by `names`.
"""

import importlib
import pkgutil
from typing import Any

from drivegen.errors import UnusableInput

_NOT_PLUGINS = {"base"}


def names(folder: str) -> list[str]:
    """All plugin names in `drivegen/<folder>`, sorted; files that begin with `_` and `base.py` are none."""
    package = importlib.import_module(f"drivegen.{folder}")
    found = (module.name for module in pkgutil.iter_modules(package.__path__))
    return sorted(name for name in found if name not in _NOT_PLUGINS and not name.startswith("_"))


def load(folder: str, name: str) -> Any:
    """The `Plugin` of `drivegen/<folder>/<name>.py`.

    Raises UnusableInput for an unknown name (listing the known ones) or a file without `Plugin`.
    """
    if name not in names(folder):
        known = ", ".join(names(folder))
        raise UnusableInput(f"no {folder} plugin is called {name!r}: choose one of {known}, or write drivegen/{folder}/{name}.py")
    module = importlib.import_module(f"drivegen.{folder}.{name}")
    if not hasattr(module, "Plugin"):
        raise UnusableInput(f"drivegen/{folder}/{name}.py must define `Plugin` (see drivegen/{folder}/base.py)")
    return module.Plugin
