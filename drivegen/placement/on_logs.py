"""Our placement on the maps of logs, so that first frames of ours stand beside those that were logged."""

from dataclasses import dataclass, replace

from drivegen.core import seeds
from drivegen.core.scenario import TARGET, Scenario, Vehicles
from drivegen.placement.draws import Draws
from drivegen.placement.place import MODES, Placer
from drivegen.placement.retrieve import draw_kinds, retrieve
from drivegen.placement.scenes import Settings, kind_named
from drivegen.placement.slots import Slots
from drivegen.placement.table import Table
from drivegen.placement.ways import closed_lanes

OURS = "DriveGen, mode {}"
NOT_GIVEN = ", a target of its own"
"""Added to the name where the log's target is not given."""


@dataclass(frozen=True)
class OnLogs:
    """Places vehicles in every mode, around a target of its own and around the log's.

    Attributes:
        table: of assets. draws: from the gaps of training logs. settings: of the placement.
    """

    table: Table
    draws: Draws
    settings: Settings
    seed: int

    @property
    def names(self) -> list[str]:
        """Of what `places` makes."""
        return [f"{OURS.format(mode)}{target}" for mode in MODES for target in (NOT_GIVEN, "")]

    def places(self, scenario: Scenario) -> dict[str, Vehicles]:
        """Vehicles by name: as many as the log has, of the same kinds under every name.

        Raises UnusableInput, reason `no-place`, where there is no room for a target or the log's is on no lane.
        """
        random = seeds.rng(self.seed, "initial_states", scenario.scenario_id)
        shares = {kind_named(word): share for word, share in self.settings.shares.items()}
        kinds = draw_kinds(shares, len(scenario.vehicles), random)
        rows = [int(retrieve(self.table, kind, 1, random)[0]) for kind in kinds]
        closed, slots = closed_lanes(scenario.signals), Slots(scenario.map)
        by_name = {}
        for mode in MODES:
            placer = Placer(slots, self.table, replace(self.settings.placement, mode=mode), self.draws)
            for suffix, target in ((NOT_GIVEN, None), ("", scenario.vehicles[[TARGET]])):
                rng = seeds.rng(self.seed, "initial_states", mode, scenario.scenario_id)
                by_name[f"{OURS.format(mode)}{suffix}"] = placer.place(rows, rng, closed, target=target).vehicles
        return by_name
