"""The project's folder as the command line finds it: the numbers of params.yaml, and what `make run` made of them."""

from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from drivegen.adversaries.shared.arena import Ground
from drivegen.adversaries.shared.ground import logged, sampled
from drivegen.asked.start import Settings as AskedSettings
from drivegen.core.errors import MissingTool
from drivegen.core.first_frame import first_frame
from drivegen.core.scenario import Scenario
from drivegen.core.settings import build, read_section
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.ingest.selection import Settings as SelectionSettings
from drivegen.placement.gaps import Gaps
from drivegen.placement.scenes import Settings as InitialSettings
from drivegen.placement.table import Table
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import choose
from drivegen.rollout.models import Equipment
from drivegen.store.assets import read_assets
from drivegen.traffic import SELECTOR

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

S = TypeVar("S", bound="DataclassInstance")

MODELS = Path("data/models")
ASSETS, GAPS = Path("data/assets.parquet"), Path("data/gaps.parquet")


def some_of(kind: type[S], section: str) -> S:
    """Those settings of a section of params.yaml that `kind` has."""
    own = read_section(section)
    return build(kind, {field.name: own[field.name] for field in fields(kind) if field.name in own}, f"params.yaml: {section}")


def selection(vehicles: int) -> SelectionSettings:
    """How recordings become scenarios: as in the ingest stage, beginning at the log's first frame."""
    settings = build(SelectionSettings, read_section("ingest.selection"), "params.yaml: ingest.selection")
    return replace(settings, max_vehicles=vehicles, first_step=0)


def initial(vehicles: int) -> InitialSettings:
    """How new scenarios begin: as in the place stage."""
    return replace(build(InitialSettings, read_section("place.initial"), "params.yaml: place.initial"), vehicles=vehicles)


def asked_settings() -> AskedSettings:
    """How traffic in words is looked for."""
    return build(AskedSettings, read_section("asked.settings"), "stages/params.yaml: asked.settings")


def generation(*, scored: bool) -> GeneratorSettings:
    """How traffic is generated: as the rollout stage does what is scored, as the ship stage does what is new."""
    section = "rollout.generation" if scored else "ship.generation"
    return build(GeneratorSettings, read_section(section), f"params.yaml: {section}")


def equipment(settings: GeneratorSettings) -> Equipment:
    """The trained models. Raises MissingTool, with the remedy, where they are absent."""
    return Equipment.open(MODELS, settings.planner, SELECTOR)


def assets() -> Table:
    """The vehicles that can be placed. Raises MissingTool where they are absent."""
    if not ASSETS.exists():
        raise MissingTool(f"{ASSETS} is not here: `make run` collects the vehicles and trains the models")
    return Table.from_arrow(read_assets(ASSETS), str(ASSETS))


def gaps(settings: InitialSettings) -> Gaps | None:
    """The gaps of the training logs, where placement draws from them. Raises MissingTool where they are absent."""
    if settings.placement.mode != "data":
        return None
    if not GAPS.exists():
        raise MissingTool(f"{GAPS} is not here: `make run` measures the gaps of the training logs")
    return Gaps.from_arrow(read_assets(GAPS), str(GAPS))


def ground(traffic: str, scenarios: Sequence[Scenario], samples: int) -> Ground:
    """The scenarios with logged (`log`) traffic or so many samples of generated traffic; goals know the first frame alone."""
    settings = generation(scored=True)
    tools = equipment(settings)
    shown = choose([first_frame(s) for s in scenarios], tools.selector, settings.candidates, settings.temperature)
    choices = [replace(choice, scenario=scenario) for choice, scenario in zip(shown, scenarios, strict=True)]
    if traffic == "log":
        return logged(choices, tools.planner, tools.limits)
    seed = read_section("run")["seed"]
    futures = roll_out(choices, tools.planner, tools.limits, settings.rollout, samples, seed, "drivegen")
    return sampled(choices, futures, samples, tools.planner, tools.limits)
