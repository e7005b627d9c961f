"""What a text asks for of traffic, held against what its author listed: numbers of vehicles by kind, density, manoeuvres."""

from collections.abc import Mapping
from typing import Any

from drivegen.core.errors import UnusableInput
from drivegen.words.read import read

_KINDS = {"cars": "car", "trucks": "truck", "buses": "bus", "vehicles": "vehicle"}


def traffic_lacking(text: str, expect: Mapping[str, Any]) -> list[str]:
    """What the request of a text lacks of what is expected, as sentences."""
    try:
        asked = read(text, 0).traffic
    except UnusableInput as error:
        return [str(error)]
    kinds = {kind.value: count for kind, count in asked.kinds.items()}
    does = sorted(group.manoeuvre.value for group in asked.groups if group.manoeuvre is not None)
    does += [asked.target_does.value] if asked.target_does is not None else []
    got: dict[str, Any] = {name: kinds.get(kind, 0) for name, kind in _KINDS.items()}
    got |= {"density": asked.density.value if asked.density is not None else None, "does": does}
    wanted = {name: sorted(want) if isinstance(want, list) else want for name, want in expect.items() if want}
    return [f"{name}: asked {want}, got {got.get(name)}" for name, want in wanted.items() if want != got.get(name)]
