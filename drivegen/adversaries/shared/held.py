"""Cases as they were handed over, made ready to be driven again among neighbours that react."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from drivegen.adversaries.shared.naturalness import exchanged
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.corner_cases.survival import partners
from drivegen.drivers.base import Driver
from drivegen.world.reactive import Reaction


@dataclass(frozen=True)
class Replay:
    """A scene with its traffic (N, T), and who is `deaf` where all but the attacker react, as in `Case`."""

    scenario: Scenario
    traffic: Trajectories
    deaf: int


def replays(
    scenarios: Sequence[Scenario], before: Sequence[Trajectories], after: Sequence[Trajectories], driver: Driver, law: Reaction
) -> list[Replay]:
    """Of each case: deaf is who moves otherwise `after` than `before`, and where nobody does the one that `driver` hits."""
    made = [
        Replay(scenario, now, int(exchanged(then, now).max(initial=0)))
        for scenario, then, now in zip(scenarios, before, after, strict=True)
    ]
    alone = [n for n, replay in enumerate(made) if not replay.deaf]
    for n, partner in zip(alone, partners([made[n] for n in alone], driver, law).tolist(), strict=True):
        made[n] = replace(made[n], deaf=max(partner, 0))
    return made
