"""Scenario initialisation (paper, section III-A): a map and a table of vehicles in, new scenarios without a log out."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drivegen.core import seeds
from drivegen.core.crop import Cropper
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import DT, TARGET, Actors, Scenario, VehicleKind
from drivegen.core.settings import Count, Positive
from drivegen.placement.beset import besetting
from drivegen.placement.draws import Draws
from drivegen.placement.gaps import Gaps
from drivegen.placement.place import Placement, Placer, PlaceSettings
from drivegen.placement.retrieve import draw_kinds, retrieve
from drivegen.placement.slots import Slots
from drivegen.placement.table import Table
from drivegen.placement.ways import closed_lanes
from drivegen.placement.where import Wish
from drivegen.sumo.network import Network

TOP_SPEED = 50.0
"""No vehicle is made that drives faster [m/s]: the checker's limit."""

DAY = 86_400.0
"""A scene begins at any second of a day, so at any of a signal's programme, however long its cycle."""


@dataclass(frozen=True)
class Settings:
    """How new scenarios begin.

    Attributes:
        vehicles: asked for, the target included. horizon: steps after the first.
        shares: of kinds, by the names of VehicleKind in lower case.
        map_radius: lanes this near to any vehicle are kept at least [m]; how far: see `Initialiser.within_reach`.
        placement: see `PlaceSettings`.
    """

    vehicles: Count
    horizon: Count
    shares: dict[str, float]
    map_radius: Positive
    placement: PlaceSettings


class Initialiser:
    """Makes any number of scenarios on one network; asked = placed + rejected.

    `gaps` are those of the training logs, which placement in mode `data` draws from.
    """

    def __init__(
        self, network: Network, name: str, source: str, table: Table, settings: Settings, gaps: Gaps | None = None
    ) -> None:
        self._network, self._name, self._source, self._table, self._settings = network, name, source, table, settings
        self._cropper = Cropper(network.map)
        self._shares = {kind_named(word): share for word, share in settings.shares.items()}
        self._placer = Placer(Slots(network.map), table, settings.placement, None if gaps is None else Draws(gaps))

    def scenario(self, number: int, seed: int, beset: bool = False) -> tuple[Scenario, dict[str, int]]:
        """Scenario `number`, and how many vehicles were not placed by reason; if `beset`, vehicles stand around the target.

        Raises UnusableInput with a countable reason where not even the target could be placed.
        """
        random = seeds.rng(seed, "place", self._name, number)
        count = self._settings.vehicles
        wishes = besetting(count) if beset else ()
        scenario, placement = self.begin(self.scenario_id(number, seed), self.drawn_rows(count, random), random, wishes)
        return scenario, placement.rejected

    def scenarios(self, count: int, seed: int, beset: bool = False) -> Iterator[Scenario]:
        """Those of the first `count` numbers for whose target there is room."""
        for number in range(count):
            try:
                yield self.scenario(number, seed, beset)[0]
            except UnusableInput as error:
                if error.reason != "no-place":
                    raise

    def scenario_id(self, number: int, seed: int) -> str:
        """Of scenario `number`: no two seeds share one, so that what is made on other days can be put together."""
        return f"{self._name}-{seed}-{number:04d}"

    @property
    def left_hand(self) -> bool:
        """Whether traffic keeps left here."""
        return self._network.left_hand

    @property
    def radius(self) -> float:
        """Social vehicles stand so near to the target [m] where nobody says how near; see `PlaceSettings`."""
        return self._settings.placement.radius

    @property
    def within_reach(self) -> float:
        """Lanes this near to any vehicle are kept [m]: nobody drives out of what is kept before the horizon."""
        return max(self._settings.map_radius, TOP_SPEED * self._settings.horizon * DT)

    def drawn_rows(self, count: int, random: np.random.Generator) -> list[int]:
        """Rows of the table for `count` vehicles of kinds by the settings' shares."""
        return [self.row_of(kind, random) for kind in draw_kinds(self._shares, count, random)]

    def row_of(self, kind: VehicleKind, random: np.random.Generator) -> int:
        """A row of the table of this kind."""
        return int(retrieve(self._table, kind, 1, random)[0])

    def begin(
        self,
        scenario_id: str,
        rows: Sequence[int],
        random: np.random.Generator,
        wishes: Sequence[Wish] = (),
        radius: float | None = None,
    ) -> tuple[Scenario, Placement]:
        """A scenario of the table's `rows`, the target first, each placed as its wish says; see `Placer.place`.

        `radius` [m] stands in for the settings' own. Raises UnusableInput, reason `no-place`, without room for the target.
        """
        settings, network = self._settings, self._network
        time = random.uniform(0.0, DAY) + DT * np.arange(settings.horizon + 1, dtype=np.float64)
        signals = network.signals(time)
        closed = closed_lanes(signals)
        placement = self._placer.place(rows, random, closed, wishes, radius=radius)
        origin = np.round(network.map.origin + placement.vehicles.position[TARGET])
        cut, lanes = self._cropper.around(placement.vehicles.position, self.within_reach)
        shift = (network.map.origin - origin).astype(np.float32)
        scenario = Scenario(
            scenario_id=scenario_id,
            source=self._source,
            city=self._name,
            map=cut.moved_to(origin),
            vehicles=replace(placement.vehicles, position=placement.vehicles.position + shift),
            horizon=settings.horizon,
            log=None,
            context=Actors.none(settings.horizon + 1),
            signals=signals.on_lanes(lanes),
        )
        return scenario, placement


def kind_named(word: str) -> VehicleKind:
    """The kind of this name, in any case. Raises UnusableInput for others."""
    try:
        return VehicleKind[word.upper()]
    except KeyError:
        raise UnusableInput(f"there is no kind of vehicle {word!r}; known are car, truck, bus") from None
