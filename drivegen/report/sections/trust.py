"""What the paper leaves out: proper scores, realism, joint consistency, distances of distributions, a classifier, boxes."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from drivegen.core.methods import Method
from drivegen.report.averaged import taken_over
from drivegen.report.evidence import Evidence
from drivegen.report.section import Section, not_measured
from drivegen.report.sections.quality import name_of
from drivegen.report.table import Cell, Table, measured, row

REALISM = {
    "realism": "score",
    "realism.linear_speed": "speed",
    "realism.linear_acceleration": "acceleration",
    "realism.angular_speed": "turning",
    "realism.angular_acceleration": "angular acceleration",
    "realism.distance_to_nearest_object": "nearest box",
    "realism.collision": "collision",
    "realism.time_to_collision": "time to collision",
    "realism.distance_to_road_edge": "road edge",
    "realism.off_road": "off-road",
}
SCORES = {
    "energy_trajectory": "energy score [m] \u2193",
    "energy_final": "at the end [m] \u2193",
    "energy_joint": "of the scene [m] \u2193",
    "energy_joint_final": "of the scene, at the end [m] \u2193",
}
DISTANCES = {
    "auc": "AUC \u2192 0.5",
    "distance.speed": "speed [m/s]",
    "distance.acceleration": "acceleration [m/s2]",
    "distance.lateral_acceleration": "lateral acceleration [m/s2]",
    "distance.jerk": "jerk [m/s3]",
    "distance.headway": "headway [s]",
    "distance.time_to_collision": "time to collision [s]",
    "distance.post_encroachment": "post-encroachment [s]",
    "distance.manoeuvres": "manoeuvres [bit]",
}
BOXES = {
    "boxes_90_collision": "boxes x 0.9",
    "boxes_100_collision": "boxes x 1.0",
    "boxes_110_collision": "boxes x 1.1",
    "boxes_overlap_initial": "given overlapping",
    "boxes_centres_meet": "centres within 1 m (av2)",
    "close_call": "steps with time to collision under 1.5 s",
    "close_call_log": "the same in the log",
    "rejected": "planned trajectories rejected",
}
JOINT = {
    "joint.collision": "touching another box \u2193",
    "shuffled.collision": "shuffled",
    "joint.order": "in the log's order \u2191",
    "shuffled.order": "shuffled",
    "energy_joint": "energy score of the scene [m] \u2193",
    "joint.energy_gain": "shuffled: more by",
    "distance.headway": "headways [s] \u2193",
    "shuffled.headway": "shuffled",
    "distance.post_encroachment": "post-encroachment [s] \u2193",
    "shuffled.post_encroachment": "shuffled",
    "encounters": "encounters per scene",
    "shuffled.encounters": "shuffled",
    "encounters_log": "in the log",
}
REALISM_NOTE = (
    "Likelihood of the log under histograms of the samples, with features, bins and weights of the 2025 challenge; its "
    "traffic light feature (0.05) is dropped and the other weights are divided by 0.95. The log does not score 1. "
    "Comparable on these scenes with this number of samples only, with no leaderboard."
)
SCORES_NOTE = (
    "Energy scores: of each vehicle's way and end, and of all vehicles at once; a method does best by sampling what it "
    "believes. They suppose samples drawn independently; the tempo of DriveGen and of its variants is spread evenly over their "
    "samples and SceneTransformer draws its futures without repetition, which makes spread look larger and so favours these; all "
    "others draw independently. NLL: of the log, in nats per vehicle, under a Gaussian kernel on the samples whose bandwidth is, "
    "for each scenario, the one that is likeliest for all of other recordings; the log's own is bounded by the finest bandwidth."
)
DISTANCES_NOTE = (
    "Wasserstein-1 distances of generated from logged motion over all scenes, of manoeuvres the Jensen-Shannon "
    "divergence. AUC: boosted trees that tell generated from logged tracks of recordings that they were not trained on."
)
BOXES_NOTE = (
    "Shares of vehicles whose box touches another one in a step that the log has of both, without the checker's tolerances; "
    "pairs that are given overlapping count only once they have come apart. Rejected: by the checker, with which only DriveGen "
    "plans; a dash is no merit."
)

JOINT_NOTE = (
    "Shuffled: the same samples, but each vehicle's trajectories dealt out anew among them, so that every marginal stays and "
    "nobody has to do with anybody; a method whose figures do not differ from its shuffles' knows no more than marginals. Order: "
    "share of the pairs that cross or join each other's way in a sample (within 10 s) who do so in the log's order, "
    "where the log tells it. Encounters: all such pairs."
)


class Reading(NamedTuple):
    """One table of measures that the paper leaves out: `columns` are headings by key."""

    name: str
    title: str
    columns: Mapping[str, str]
    note: str
    digits: int = 2


def readings(measured_keys: Iterable[str]) -> tuple[Reading, ...]:
    """The five tables; that of proper scores has a column for every likelihood among the keys that were measured."""
    likelihoods = {name: horizon_words(name) for name in sorted(set(measured_keys)) if is_likelihood(name)}
    return (
        Reading("realism", "Realism in the manner of WOSAC", REALISM, REALISM_NOTE),
        Reading("scores", "Proper scores", SCORES | likelihoods, SCORES_NOTE),
        Reading("joint", "Joint consistency: samples beside the same samples shuffled", JOINT, JOINT_NOTE, 3),
        Reading("distances", "Distances of distributions, and a classifier", DISTANCES, DISTANCES_NOTE),
        Reading("boxes", "What collision rates owe to box sizes, and what is rejected", BOXES, BOXES_NOTE, 3),
    )


def section(evidence: Evidence) -> Section:
    """Five tables over all methods; one that has not run says so."""
    methods = evidence.ordered(evidence.below("quality_details"))
    lead = (
        "What the paper does not report. The log's own row says what perfect is worth on these data, constant velocity's what "
        "nothing learned is worth. Means over scenarios with bootstrap intervals over recordings."
    )
    if not methods:
        return Section("trust", "Trust in the numbers", lead, missing=not_measured("evaluate"))
    there = readings(name for values in methods.values() for name in values)
    return Section("trust", "Trust in the numbers", lead, tuple(_table(one, methods, evidence) for one in there))


def _table(reading: Reading, methods: Mapping[str, dict[str, Any]], evidence: Evidence) -> Table:
    lines = [
        row(
            name_of(name, methods, evidence),
            *(_cell(evidence.methods.get(name), values, key, reading.digits) for key in reading.columns),
            origin=evidence.origin(name),
        )
        for name, values in evidence.rows(methods).items()
    ]
    notes = (*evidence.trained_on, *taken_over(methods), reading.note)
    return Table(reading.name, reading.title, ("", *reading.columns.values()), tuple(lines), notes)


def _cell(method: Method | None, values: dict[str, Any], key: str, digits: int) -> Cell:
    return Cell("–") if values and not has(method, key) else measured(values, key, digits)


def has(method: Method | None, key: str) -> bool:
    """Whether a measure means anything for a method: nothing is rejected where no checker looks on, as it does on goals."""
    return key != "rejected" or (method is not None and method.goals is not None)


def is_likelihood(name: str) -> bool:
    """Whether a key is a likelihood of the log, and not an end of its interval."""
    return name.startswith("nll_") and not name.endswith((".low", ".high"))


def horizon_words(name: str) -> str:
    """A key as a heading: "nll_joint_3s" -> "NLL of the scene at 3 s"."""
    *kind, horizon = name.split("_")
    return f"NLL{' of the scene' if 'joint' in kind else ''} at {horizon.removesuffix('s')} s \u2193"
