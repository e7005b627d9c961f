"""A person's edit of a map on disk: its specification is read, edited by whoever reads words, and built again."""

from collections.abc import Callable
from pathlib import Path

from pydantic import ValidationError

from drivegen.core import safe_json
from drivegen.core.errors import UnusableInput
from drivegen.layouts.spec import MapSpec
from drivegen.maps.build import ACCOUNT, BuiltMap, build_spec


def refine_map(folder: Path, text: str, edit: Callable[[MapSpec, str], MapSpec]) -> BuiltMap:
    """The map in `folder` after one more edit; its account keeps the edits so far, with the specification before each.

    Raises UnusableInput where the folder holds no map with a specification, or as `edit` does. Nothing is written.
    """
    file = folder / ACCOUNT
    try:
        account = safe_json.parse(file.read_bytes(), file)
        spec = MapSpec.model_validate(account["spec"])
        history = [{"edit": str(done["edit"]), "before": done["before"]} for done in account.get("history", [])]
    except FileNotFoundError:
        raise UnusableInput(f"{file} is not there: make the map first", reason="no-map") from None
    except (KeyError, TypeError, ValidationError):
        what = f"{file} holds no map specification, as of imported maps, which cannot be refined"
        raise UnusableInput(f"{what}: change the network in SUMO's netedit and import it", reason="no-map") from None
    done = {"edit": text, "before": account["spec"]}
    kept = {name: account[name] for name in ("text", "seed", "backend", "understood", "assumed", "ignored") if name in account}
    return build_spec(edit(spec, text), {**kept, "history": [*history, done]})
