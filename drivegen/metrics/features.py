"""Everything that is read off one scene's motion step by step: what realism, distances and the classifier compare.

The log is taken as one more sample, so that both sides are measured by the same code. Generated motion takes the log's mask:
a step that the log did not observe counts for nobody. (Waymo masks the log only; a published bug counted such steps as off-road.)
A vehicle that has left the map does not move, is near nobody and in nobody's way; that it stands at its exit is for errors alone.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegen.core.scenario import Scenario, Trajectories
from drivegen.metrics.displacement import scored_steps
from drivegen.metrics.kinematics import Kinematics, kinematics, within
from drivegen.metrics.road_edge import RoadEdges, edge_distance
from drivegen.metrics.surroundings import Boxes, Surroundings, surroundings


@dataclass(frozen=True)
class Features:
    """Features of K samples of N vehicles over T steps, each (K, N, T).

    Attributes:
        motion: the samples, valid where the log is until they leave the map. kinematics: differences of positions and headings.
        around: the other boxes. edge: signed distance of the outermost corner to the road's edge [m].
        known: masks (K, N, T) of the steps at which a feature of order 0, 1 (speed), 2 (acceleration), 3 (jerk) counts: the
            first frame is given to everybody and never counts.
    """

    motion: Trajectories
    kinematics: Kinematics
    around: Surroundings
    edge: NDArray[np.float32]
    known: tuple[NDArray[np.bool_], ...]

    def __getitem__(self, index: Any) -> "Features":
        """The chosen samples, as in `features[:-1]`."""
        return Features(
            self.motion[index],
            Kinematics(*(values[index] for values in vars(self.kinematics).values())),
            Surroundings(*(values[index] for values in vars(self.around).values())),
            self.edge[index],
            tuple(mask[index] for mask in self.known),
        )


def joined(samples: Trajectories, log: Trajectories) -> Trajectories:
    """Samples (K, N, T) and the log (N, T) as K + 1 samples, the log last, none valid where the log is not."""
    return Trajectories(
        np.concatenate([samples.position, log.position[None]]),
        np.concatenate([samples.heading, log.heading[None]]),
        np.concatenate([samples.velocity, log.velocity[None]]),
        np.concatenate([samples.valid & log.valid, log.valid[None]]),
    )


def scene_features(
    scenario: Scenario, samples: Trajectories, log: Trajectories, edges: RoadEdges | None
) -> tuple[Features, Boxes]:
    """Features of K samples (K, N, T) and, last, of the log; and the boxes that they were taken from.

    Without `edges` nothing is known of the road, and `edge` is NaN.
    """
    both = joined(samples, log)
    count = len(scenario.vehicles)
    boxes = Boxes.of(both, scenario.vehicles.size, scenario.context)
    scored = scored_steps(log)
    known = tuple(within(both.valid, order) & scored for order in range(4))
    around = surroundings(boxes, count)
    edge = np.full(both.valid.shape, np.nan, np.float32) if edges is None else edge_distance(boxes, count, edges)
    return Features(both, kinematics(both), around, edge, known), boxes
