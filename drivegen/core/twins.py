"""Logs as a data set of fewer layers would hold them, so that whatever learns from logs also learns to do without.

Argoverse 2 tells neither signals nor who has to wait nor speed limits, the NGSIM recordings no signals; the simulated
corpus tells all of it. A ranker that has never met a queue at a light that it does not see believes that it stays. DriveGen's
goal selector and all learned generators that it is compared with learn from every log and from its twin.
"""

from dataclasses import replace

import numpy as np

from drivegen.core import seeds
from drivegen.core.roadmap import LaneControl
from drivegen.core.scenario import Scenario
from drivegen.core.signals import Signals

LIMITS_KNOWN = 0.5
"""Share of the twins that keep their speed limits."""


def twin(scenario: Scenario) -> Scenario:
    """`scenario` without signals and rules of way, and, drawn by its id, without speed limits."""
    unruled = np.full_like(scenario.map.control, LaneControl.UNKNOWN)
    road_map = replace(scenario.map, control=unruled, yields_to=scenario.map.yields_to[:0])
    if seeds.rng(0, "twin", scenario.scenario_id).random() >= LIMITS_KNOWN:
        road_map = replace(road_map, speed_limit=np.full_like(road_map.speed_limit, np.nan))
    return replace(scenario, map=road_map, signals=Signals.none(scenario.steps))
