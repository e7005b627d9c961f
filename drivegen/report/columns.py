"""The columns that tables of methods have, how a figure in each is read, and how a method's name is marked for its figures."""

from collections.abc import Mapping

from drivegen.core.methods import LEARNED, Method

FIVE = ("min_sade", "min_sfde", "mean_sade", "mean_sfde", "diversity")
"""The paper's columns."""

FLOOR = "constant_velocity"
"""What a method must beat to count."""

MARKS = (
    "A rival that does not beat constant velocity in min-sADE is marked under-trained: beating it counts for nothing.",
    "That is lenient, for it is the best of several samples against one: so who does not beat it in mean-sADE is marked, too.",
)
"""Notes on what `mark` puts behind names."""

SAFETY = {"collision_per_vehicle": "in collision", "off_road_per_vehicle": "off road", "illegal_per_vehicle": "any violation"}
EDGES = {"left_map_per_vehicle": "left the map", "beyond_rim": "steps beyond the rim"}
EDGES_MEAN = (
    "Who drives out where the road network itself ends has left the map: that is no violation. Where a map is cut off the road "
    "goes on, though nobody knows how: no rule of the road is applied beyond that rim, where vehicles may still collide. Logs "
    "of SUMO end ahead of an exit, where it takes out who reaches it, so that nobody of theirs can be seen to leave. Of "
    "generated traffic all steps count, of the log those that it has, so it is charged with less; for collisions in the "
    "log's steps alone see the shares of boxes that touch."
)
"""Shares of vehicles that the legal checker objects to."""

AIMS = {"diversity": 1.0, "auc": 0.5}
"""Measures that are best at a number, and not at either end."""


def mark(name: str, about: Method | None, errors: Mapping[str, float | None], floor: Mapping[str, float | None]) -> str:
    """What stands behind a method's name, "" if nothing, from its `errors` and constant velocity's by metric; see MARKS."""
    if name == FLOOR or about is None or not about.competes:
        return ""
    if about.kind == LEARNED and _no_better(errors, floor, "min_sade"):
        return ", under-trained"
    if _no_better(errors, floor, "mean_sade"):
        return ", not better than constant velocity in the mean"
    return ""


def _no_better(errors: Mapping[str, float | None], floor: Mapping[str, float | None], metric: str) -> bool:
    mine, theirs = errors.get(metric), floor.get(metric)
    return mine is not None and theirs is not None and mine >= theirs


def badness(metric: str, value: float) -> float:
    """What is smaller the better a figure of this metric is."""
    if metric in AIMS:
        return abs(value - AIMS[metric])
    return -value if metric.startswith("realism") or metric == "joint.order" else value
