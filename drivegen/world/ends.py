"""Where runs end but for collisions: at an exit of the map, and, for targets that move freely, off the road."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import torch
from torch import Tensor

from drivegen.core.scenario import TARGET, Scenario, Trajectories
from drivegen.roads.drivable import CELL, road_surface
from drivegen.roads.leaving import Exits
from drivegen.world.observation import PATH_SPACING
from drivegen.world.outcome import OFF_ROAD_TOLERANCE
from drivegen.world.scenes import Scenes


def exits(scenes: Scenes, scenarios: Sequence[Scenario]) -> Tensor:
    """(S,) [m] how far along its path a target has left the map, inf if never; scenarios that share a map share its exits."""
    maps = {id(s.map): s.map for s in scenarios}
    ways_out = {number: Exits.of(road_map) for number, road_map in maps.items()}
    place = np.full(len(scenes), np.inf, np.float32)
    for s, scenario in enumerate(scenarios):
        points = int(scenes.paths.length[s] / PATH_SPACING) + 1
        position, heading = (tensor[s, :points].cpu().numpy() for tensor in (scenes.paths.point, scenes.paths.heading))
        driven = Trajectories(position, heading, np.zeros_like(position), np.ones(points, np.bool_))
        step = int(ways_out[id(scenario.map)].crossings(driven, scenario.vehicles.size[TARGET, 0]))
        place[s] = step * PATH_SPACING if step >= 0 else np.inf
    return torch.from_numpy(place).to(scenes.steps.device)


@dataclass(frozen=True)
class Surface:
    """The rasters of all maps of S scenes, one after the other; about a byte a cell.

    Attributes:
        off: (C,) bool cells that are off the road by more than OFF_ROAD_TOLERANCE. first: (S,) int64 each scene's first cell.
        shape: (S, 2) int64 its rows and columns. origin: (S, 2) [m] its first cell. around: (S,) bool, off beyond its raster.
    """

    off: Tensor
    first: Tensor
    shape: Tensor
    origin: Tensor
    around: Tensor

    @classmethod
    def of(cls, scenarios: Sequence[Scenario], device: torch.device | str = "cpu") -> Self:
        """The rasters of `scenarios`; those that share a map share its raster."""
        maps = {id(scenario.map): scenario.map for scenario in scenarios}
        fields = [road_surface(road_map) for road_map in maps.values()]
        start = np.cumsum([0, *(field.outside.size for field in fields)])[:-1]
        which = [list(maps).index(id(scenario.map)) for scenario in scenarios]
        return cls(
            torch.from_numpy(np.concatenate([(field.outside > OFF_ROAD_TOLERANCE).ravel() for field in fields])).to(device),
            torch.tensor([int(start[i]) for i in which], device=device),
            torch.tensor([fields[i].outside.shape for i in which], device=device),
            torch.from_numpy(np.stack([fields[i].origin for i in which])).to(device),
            torch.tensor([fields[i].around > OFF_ROAD_TOLERANCE for i in which], device=device),
        )

    def off_road(self, scene: Tensor, position: Tensor, heading: Tensor, size: Tensor) -> Tensor:
        """(R,) whether boxes at `position` (R, 2), `heading` (R,) of `size` (R, 2) in `scene` (R,) have a corner off the road."""
        forward = torch.stack([heading.cos(), heading.sin()], -1) * (0.5 * size[:, :1])
        left = torch.stack([-heading.sin(), heading.cos()], -1) * (0.5 * size[:, 1:])
        corner = position[:, None] + torch.stack([forward + left, forward - left, left - forward, -forward - left], 1)
        cell = ((corner - self.origin[scene][:, None]) / CELL).round().long()
        shape = self.shape[scene][:, None]
        inside = (cell >= 0).all(-1) & (cell[..., 1] < shape[..., 0]) & (cell[..., 0] < shape[..., 1])
        index = self.first[scene][:, None] + cell[..., 1] * shape[..., 1] + cell[..., 0]
        return torch.where(inside, self.off[torch.where(inside, index, 0)], self.around[scene][:, None]).any(1)
