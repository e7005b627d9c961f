"""All that is measured on one scene: its numbers, and what measures over a whole set of scenes need of it."""

from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivegen.core.samples import Samples
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.metrics.classifier import TrackPairs, track_pairs
from drivegen.metrics.displacement import scene_errors, scored_steps, standing_at_exit, summarise
from drivegen.metrics.distributions import SceneCounts, scene_counts
from drivegen.metrics.features import scene_features
from drivegen.metrics.joint import SceneJoint, scene_joint
from drivegen.metrics.labels import label
from drivegen.metrics.proper import energy_scores, log_densities, spread
from drivegen.metrics.realism import realism
from drivegen.metrics.road_edge import RoadEdges
from drivegen.metrics.safety import box_rates, safety_rates, sample_rates, violation_shares


@dataclass(frozen=True)
class Settings:
    """What is declared, not measured.

    Attributes:
        horizons: at which the log's likelihood under the samples is taken [s].
        bandwidths: of the kernel that turns samples into a density, to choose from [m].
        box_scales: all boxes are scaled by each of these, to see what collision rates owe to sizes.
    """

    horizons: tuple[float, ...]
    bandwidths: tuple[float, ...]
    box_scales: tuple[float, ...]


@dataclass(frozen=True)
class Scored:
    """One scene's numbers, the three motions (N, T) that diversity compares, and parts of what only a set of scenes has.

    Attributes:
        scenario: its id. metrics: by name. samples: of each of its K samples, (K,) by name.
        log, best, any_sample: the log, the sample of least sADE and one drawn by seed, valid where the log is.
        counts: histograms of motion. tracks: features of tracks. densities: (2, H, B), see `proper.log_densities`.
        joint: beside the same samples shuffled.
    """

    scenario: str
    metrics: dict[str, float]
    samples: dict[str, NDArray[np.float64]]
    log: Trajectories
    best: Trajectories
    any_sample: Trajectories
    counts: SceneCounts
    tracks: TrackPairs
    densities: NDArray[np.float64]
    joint: SceneJoint


def score(
    scenario: Scenario, log: Trajectories, samples: Samples, edges: RoadEdges, settings: Settings, rng: np.random.Generator
) -> Scored:
    """Measure one scene's samples against its log; `rng` draws the sample that stands for all where one does, and shuffles."""
    motion = standing_at_exit(samples.motion, log)
    sade, sfde = scene_errors(motion, log)
    drawn = int(rng.integers(len(sade)))
    features, boxes = scene_features(scenario, motion, log, edges)
    counts = scene_counts(features)
    joint = scene_joint(scenario, log, features, boxes, rng)
    metrics = {
        **asdict(summarise(sade, sfde)),
        **asdict(energy_scores(motion, log)),
        "spread": spread(motion, log),
        **{f"realism.{name}".removesuffix(".score"): value for name, value in realism(features).items()},
        **asdict(safety_rates(samples)),
        **{f"violation.{kind}": share for kind, share in violation_shares(samples).items()},
        "beyond_rim": float(edges.beyond_rim(samples.motion.position)[samples.motion.valid].mean()),
        **box_rates(boxes, len(log.valid), settings.box_scales),
        **joint.metrics,
        "close_call": float(counts.close_call[1]),
        "close_call_log": float(counts.close_call[0]),
        "encounters": float(counts.encounters[1]),
        "encounters_log": float(counts.encounters[0]),
        "attempts": float(samples.attempts.mean()),
        "rejected": float(1 - samples.attempts.size / max(int(samples.attempts.sum()), samples.attempts.size)),
        "steps": float(log.steps),
        "agent_steps": float(scored_steps(log).sum()),
        "vehicles": float(len(scenario.vehicles)),
        **label(scenario, log).as_rows(),
    }
    best, any_sample = (replace(motion[k], valid=log.valid) for k in (int(np.argmin(sade)), drawn))
    tracks = track_pairs(features, drawn)
    horizons, bandwidths = np.array(settings.horizons), np.array(settings.bandwidths)
    densities = log_densities(motion, log, horizons, bandwidths)
    each = {"sade": sade, "sfde": sfde, **sample_rates(samples)}
    return Scored(scenario.scenario_id, metrics, each, log, best, any_sample, counts, tracks, densities, joint)
