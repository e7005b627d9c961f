"""Find a plugin by its name: the file `drivegen/<folder>/<name>.py` is the plugin `<name>`.

Each plugin module exposes `Plugin`, a class (or factory) that the folder's `base.py` describes by a protocol.
Adding one is adding one file; the folder's contract test finds it by `names`.
"""

import ast
import importlib
import importlib.util
import pkgutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from drivegen.core.errors import UnusableInput
from drivegen.core.settings import build, file_of

_NOT_PLUGINS = {"base"}


def names(folder: str, first: Iterable[str] = ()) -> list[str]:
    """All plugin names in `drivegen/<folder>`: those of `first` in their order, then the rest, sorted.

    Files that begin with `_`, `base.py` and folders are none.
    """
    package = importlib.import_module(f"drivegen.{folder}")
    modules = (module.name for module in pkgutil.iter_modules(package.__path__) if not module.ispkg)
    public = sorted(name for name in modules if name not in _NOT_PLUGINS and not name.startswith("_"))
    return list(dict.fromkeys([*(name for name in first if name in public), *public]))


def load(folder: str, name: str) -> Any:
    """The `Plugin` of `drivegen/<folder>/<name>.py`.

    Raises UnusableInput for an unknown name (listing the known ones) or a file without `Plugin`.
    """
    _expect(folder, name)
    module = importlib.import_module(f"drivegen.{folder}.{name}")
    if not hasattr(module, "Plugin"):
        raise UnusableInput(f"drivegen/{folder}/{name}.py must define `Plugin` (see drivegen/{folder}/base.py)")
    return module.Plugin


def make(folder: str, name: str, settings: Mapping[str, Any], section: str) -> Any:
    """The plugin made with its own of `settings`, which stand by its name in that section of the parameters.

    Raises UnusableInput as `load` does, where there are none, and where they are not what its `settings_type` says.
    """
    plugin, file = load(folder, name), file_of(section)
    if name not in settings:
        raise UnusableInput(f"{file}: {section} has no settings for {name!r}: write them there")
    return plugin(build(plugin.settings_type, settings[name], f"{file}: {section}.{name}"))


def about(folder: str, name: str) -> dict[str, Any]:
    """What `drivegen/<folder>/<name>.py` says of itself: the keywords of its `ABOUT = ...(...)`. The file is not run.

    Raises UnusableInput for an unknown name, a file without ABOUT and one whose keywords are no literals.
    """
    _expect(folder, name)
    spec = importlib.util.find_spec(f"drivegen.{folder}.{name}")
    assert spec is not None
    assert spec.origin is not None
    try:
        for node in ast.parse(Path(spec.origin).read_text()).body:
            match node:
                case ast.Assign(targets=[ast.Name(id="ABOUT")], value=ast.Call(keywords=keywords)):
                    return {str(keyword.arg): ast.literal_eval(keyword.value) for keyword in keywords}
    except (SyntaxError, ValueError) as error:
        raise UnusableInput(f"drivegen/{folder}/{name}.py: ABOUT must be made of literals ({error})") from None
    raise UnusableInput(f"drivegen/{folder}/{name}.py must say what it is by `ABOUT = ...` (see drivegen/{folder}/base.py)")


def _expect(folder: str, name: str) -> None:
    if name not in (choices := names(folder)):
        raise UnusableInput(
            f"no {folder} plugin is called {name!r}: choose one of {', '.join(choices)}, or write drivegen/{folder}/{name}.py"
        )
