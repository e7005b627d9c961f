"""From words, or from a specification, to a map on disk: `map.net.xml` (SUMO), `map.json` (the account), `map.png`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivegen.core.roadmap import RoadMap
from drivegen.layouts.spec import MapSpec
from drivegen.maps.checks import Check, failures
from drivegen.maps.examine import NETWORK as NETWORK
from drivegen.maps.examine import WrittenNetwork, examine
from drivegen.maps.structure import Structure
from drivegen.maps.writers.base import MapWriter, Understanding
from drivegen.render.map_picture import draw_map
from drivegen.render.png import png
from drivegen.store.files import as_json, write_together

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
        """Whether every check passed, and nothing of the description is contradicted."""
        return not self.account["failed"]

    @property
    def caption(self) -> str:
        """What stands below the picture: the description, and each edit since."""
        return "; ".join([str(self.account.get("text", "")), *(done["edit"] for done in self.account.get("history", ()))])

    def save(self, folder: Path) -> None:
        """Write the three files into `folder`, all or none: those of an older map stay where they cannot be written."""
        picture = png(draw_map(self.road_map, self.caption)[..., ::-1], compression=6)
        write_together(folder, {NETWORK: self.network, PICTURE: picture, ACCOUNT: as_json(self.account)})


def build_map(text: str, seed: int, writer: MapWriter, folder: Path | None = None) -> BuiltMap:
    """The map that `text` describes, by `writer`, saved into `folder` if one is given.

    Raises UnusableInput (not understood, impossible) or MissingTool (netconvert).
    """
    understanding = writer.write(text, seed)
    account = {"text": text, "seed": seed, "backend": understanding.writer, **_told(understanding)}
    built = build_spec(understanding.spec, account, understanding.contradictions)
    if folder is not None:
        built.save(folder)
    return built


def build_spec(spec: MapSpec | WrittenNetwork, account: dict[str, Any], contradictions: Sequence[str] = ()) -> BuiltMap:
    """The map of a specification, or of a network that was written.

    `account` is what is known about where it comes from, `contradictions` what of the description it contradicts.
    """
    findings = examine(spec)
    fields = {**account, **_source(spec), "checks": findings.checks, "failed": [*failures(findings.checks), *contradictions]}
    fields["structure"] = findings.structure
    return BuiltMap(findings.network, findings.road_map, findings.structure, findings.checks, fields)


def _source(spec: MapSpec | WrittenNetwork) -> dict[str, Any]:
    if isinstance(spec, MapSpec):
        return {"kind": spec.road.kind, "spec": spec.model_dump(mode="json")}
    return {"kind": "xml", "asked": spec.asked, "xml": {name: text.decode() for name, text in spec.plain.files().items()}}


def _told(understanding: Understanding) -> dict[str, Any]:
    return {
        "understood": [{"phrase": phrase, "meaning": meaning} for phrase, meaning in understanding.understood],
        "assumed": list(understanding.assumed),
        "ignored": list(understanding.ignored),
        "sentences": list(understanding.sentences),
        "repairs": understanding.repairs,
    }
