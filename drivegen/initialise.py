"""Scenario initialisation (paper, section III-A): a map and a table of vehicles in, new scenarios without a log out."""

from dataclasses import dataclass, replace

import numpy as np

from drivegen import seeds
from drivegen.assets.place import PlaceSettings, place_vehicles
from drivegen.assets.retrieve import draw_kinds, retrieve
from drivegen.assets.slots import Slots
from drivegen.assets.table import Table
from drivegen.crop import Cropper
from drivegen.errors import UnusableInput
from drivegen.scenario import DT, TARGET, Actors, Scenario, SignalState, VehicleKind
from drivegen.sumo.network import Network

CLOSED = (SignalState.RED, SignalState.YELLOW)
"""Nobody starts moving just before a signal that shows one of these."""


@dataclass(frozen=True)
class Settings:
    """How new scenarios begin.

    Attributes:
        vehicles: asked for, the target included. horizon: steps after the first.
        shares: of kinds, by the names of VehicleKind in lower case.
        map_radius: lanes this near to the target are kept [m].
        longest_cycle: signal programs begin at a random time within this [s].
        placement: see `PlaceSettings`.
    """

    vehicles: int
    horizon: int
    shares: dict[str, float]
    map_radius: float
    longest_cycle: float
    placement: PlaceSettings


class Initialiser:
    """Makes any number of scenarios on one network; asked = placed + rejected."""

    def __init__(self, network: Network, name: str, source: str, table: Table, settings: Settings) -> None:
        self._network, self._name, self._source, self._table, self._settings = network, name, source, table, settings
        self._slots, self._cropper = Slots(network.map), Cropper(network.map)
        self._shares = {_kind(word): share for word, share in settings.shares.items()}

    def scenario(self, number: int, seed: int) -> tuple[Scenario, dict[str, int]]:
        """Scenario `number`, and how many vehicles were not placed by reason.

        Raises UnusableInput with a countable reason where not even the target could be placed.
        """
        settings, network = self._settings, self._network
        random = seeds.rng(seed, "place", self._name, number)
        time = random.uniform(0.0, settings.longest_cycle) + DT * np.arange(settings.horizon + 1)
        signals = network.signals(time.astype(np.float64))
        rows = [int(retrieve(self._table, kind, 1, random)[0]) for kind in draw_kinds(self._shares, settings.vehicles, random)]
        closed = signals.lane[np.isin(signals.state[:, 0], CLOSED)]
        placement = place_vehicles(self._slots, self._table, rows, settings.placement, random, closed)
        origin = np.round(network.map.origin + placement.vehicles.position[TARGET])
        cut, lanes = self._cropper.around(placement.vehicles.position[:1], settings.map_radius)
        shift = (network.map.origin - origin).astype(np.float32)
        scenario = Scenario(
            scenario_id=f"{self._name}-{number:04d}",
            source=self._source,
            city=self._name,
            map=cut.moved_to(origin),
            vehicles=replace(placement.vehicles, position=placement.vehicles.position + shift),
            horizon=settings.horizon,
            log=None,
            context=Actors.none(settings.horizon + 1),
            signals=signals.on_lanes(lanes),
        )
        return scenario, placement.rejected


def _kind(word: str) -> VehicleKind:
    try:
        return VehicleKind[word.upper()]
    except KeyError:
        raise UnusableInput(f"there is no kind of vehicle {word!r}; known are car, truck, bus") from None
