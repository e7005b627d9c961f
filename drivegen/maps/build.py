"""From words, or from a specification, to a map on disk: `map.net.xml` (SUMO), `map.json` (the account), `map.png`."""

from collections.abc import Set
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivegen import plugins
from drivegen.maps.checks import Check, failures
from drivegen.maps.examine import NETWORK as NETWORK
from drivegen.maps.examine import WrittenNetwork, examine
from drivegen.maps.spec import MapSpec
from drivegen.maps.structure import Structure
from drivegen.maps.writers.base import MapWriter, Understanding
from drivegen.render.map_picture import draw_map, encode_png
from drivegen.roadmap import RoadMap
from drivegen.store.files import as_json, write_together
from drivegen.sumo.network import read_network

if TYPE_CHECKING:
    from drivegen.lm.model import LanguageModel

ACCOUNT, PICTURE = "map.json", "map.png"
"""Names of the files of a map's folder, beside its `NETWORK`."""


@dataclass(frozen=True)
class BuiltMap:
    """A map that was drawn, built and checked.

    Attributes:
        network: the SUMO network's bytes. road_map: the same as our road map.
        structure: what the network really is. checks: what was asked against it.
        account: everything for `map.json`.
    """

    network: bytes
    road_map: RoadMap
    structure: Structure
    checks: tuple[Check, ...]
    account: dict[str, Any]

    @property
    def as_asked(self) -> bool:
        """Whether every check passed."""
        return all(c.passed for c in self.checks)

    def save(self, folder: Path) -> None:
        """Write the three files into `folder`, all or none: those of an older map stay where they cannot be written."""
        picture = encode_png(draw_map(self.road_map, str(self.account.get("text", ""))))
        write_together(folder, {NETWORK: self.network, PICTURE: picture, ACCOUNT: as_json(self.account)})


def build_map(
    text: str,
    seed: int,
    writer: str = "offline",
    vehicle_words: Set[str] = frozenset(),
    folder: Path | None = None,
    model: "LanguageModel | None" = None,
) -> BuiltMap:
    """The map that `text` describes, saved into `folder` if one is given; `model` is for the writer `language_model`.

    Raises UnusableInput (not understood, impossible) or MissingTool (netconvert).
    """
    plugin: MapWriter = plugins.load("maps.writers", writer)(model)
    understanding = plugin.write(text, seed, vehicle_words)
    built = build_spec(understanding.spec, {"text": text, "seed": seed, "backend": understanding.writer, **_told(understanding)})
    if folder is not None:
        built.save(folder)
    return built


def build_spec(spec: MapSpec | WrittenNetwork, account: dict[str, Any]) -> BuiltMap:
    """The map of a specification, or of a network that was written; `account` is what is known about where it comes from."""
    found = examine(spec)
    told = {**account, **_source(spec), "checks": found.checks, "failed": failures(found.checks), "structure": found.structure}
    return BuiltMap(found.network, read_network(found.network, NETWORK), found.structure, found.checks, told)


def _source(spec: MapSpec | WrittenNetwork) -> dict[str, Any]:
    if isinstance(spec, MapSpec):
        return {"kind": spec.road.kind, "spec": spec.model_dump(mode="json")}
    return {"kind": "xml", "asked": spec.asked, "xml": {name: text.decode() for name, text in spec.plain.files().items()}}


def _told(understanding: Understanding) -> dict[str, Any]:
    return {
        "understood": [{"phrase": phrase, "meaning": meaning} for phrase, meaning in understanding.understood],
        "assumed": list(understanding.assumed),
        "ignored": list(understanding.ignored),
        "repairs": understanding.repairs,
    }
