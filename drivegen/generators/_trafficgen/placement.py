"""TrafficGen's initialisation: vehicles are put onto a map one by one, around a target that stands there.

What is the paper's: pieces of lanes are the regions; boxes placed so far are encoded by context gating, then the regions in
their context; each region has odds of holding one more vehicle, and a mixture for where on it, how turned, how fast and how
large; who overlaps is drawn anew. What is reduced: one mixture of independent Gaussians for all attributes together instead
of one each, and as many regions as `placement_lanes` says: they have to reach as far as vehicles of the logs stand.
"""

from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from drivegen.core.geometry import boxes_overlap, unit, wrap_angle
from drivegen.core.scenario import TARGET, Scenario, SizeSource, VehicleKind, Vehicles
from drivegen.generators._trafficgen.net import Encoder
from drivegen.generators._trafficgen.vectors import Surroundings
from drivegen.generators.shared.closed_loop import Crowd
from drivegen.generators.shared.lanes import REACH, LaneVectors, Logs
from drivegen.generators.shared.moments import Moments

ATTRIBUTES = 6
"""Part of the region passed, offset to its left [m], heading against it [rad], speed [10 m/s], length [5 m], width [2 m]."""

COMPONENTS = 4
"""Of the mixture."""

KINDS = (VehicleKind.CAR, VehicleKind.TRUCK, VehicleKind.BUS)

HEIGHT = 1.6
"""Nothing learns heights [m]."""

WITHIN, AGREEING = 2.5, 1.0
"""A vehicle belongs to the region under it [m] whose direction it agrees with [rad]."""

TRIES = 8
"""Draws for one vehicle until it overlaps nobody."""

_SIGMA = (-4.0, 1.0)


class Regions(NamedTuple):
    """Of B scenes: odds (B, V) of one more vehicle in each region, log weights (B, V, C) of the mixture, its means and
    log-sigmas (B, V, C, ATTRIBUTES), logits of KINDS (B, V, 3).
    """

    odds: Tensor
    weight: Tensor
    mean: Tensor
    sigma: Tensor
    kind: Tensor


class PlacementNet(nn.Module):
    """Encoder and heads per region."""

    def __init__(self, width: int, layers: int) -> None:
        super().__init__()
        self.encoder = Encoder(width, layers)
        wanted = 1 + len(KINDS) + COMPONENTS * (1 + 2 * ATTRIBUTES)
        self.head = nn.Sequential(nn.Linear(2 * width, width), nn.ReLU(), nn.Linear(width, wanted))

    def forward(self, lanes: Tensor, lane_there: Tensor, boxes: Tensor, box_there: Tensor) -> Regions:
        """From `Surroundings` of the target, with the boxes placed so far."""
        lane, _, context = self.encoder(lanes, lane_there, boxes, box_there)
        out = self.head(torch.cat([lane, context[:, None].expand_as(lane)], dim=-1))
        odds, kind, rest = out.split([1, len(KINDS), COMPONENTS * (1 + 2 * ATTRIBUTES)], dim=-1)
        mixture = rest.unflatten(-1, (COMPONENTS, 1 + 2 * ATTRIBUTES))
        sigma = mixture[..., 1 + ATTRIBUTES :].clamp(*_SIGMA)
        weight = mixture[..., 0].log_softmax(dim=-1)
        return Regions(odds[..., 0].masked_fill(~lane_there, -1e4), weight, mixture[..., 1 : 1 + ATTRIBUTES], sigma, kind)


class Wanted(NamedTuple):
    """Where vehicles are that are not placed yet: region (B, W) and whether there is one (B, W), attributes (B, W, ATTRIBUTES),
    number in KINDS (B, W).
    """

    region: Tensor
    there: Tensor
    attributes: Tensor
    kind: Tensor


def placement_loss(regions: Regions, wanted: Wanted) -> Tensor:
    """Binary cross-entropy of the regions, and likelihood of the attributes and kinds in those with a vehicle."""
    at = (wanted.there.nonzero()[:, 0], wanted.region[wanted.there])
    filled = torch.zeros_like(regions.odds)
    filled[at] = 1.0
    real = regions.odds > -1e4
    odds = functional.binary_cross_entropy_with_logits(regions.odds[real], filled[real], reduction="sum") / len(filled)
    if not len(at[0]):
        return odds
    gap = (wanted.attributes[wanted.there][:, None] - regions.mean[at]) / regions.sigma[at].exp()
    density = (-0.5 * gap.square() - regions.sigma[at]).sum(dim=-1) + regions.weight[at]
    return odds - density.logsumexp(dim=-1).mean() + functional.cross_entropy(regions.kind[at], wanted.kind[wanted.there])


class PlacementExamples:
    """Scenes at steps at which their target is seen; of the other vehicles some are given and some are to be placed."""

    def __init__(self, logs: Logs, counts: tuple[int, int]) -> None:
        self.lanes, self.counts = logs.lanes, counts
        self.moments = Moments(logs.tracks, 1, 0, boxes=logs.tracks.start[:-1])

    def of(self, rows: NDArray[np.integer], share: NDArray[np.floating]) -> tuple[tuple[Tensor, ...], Wanted]:
        """Inputs and what is wanted for examples `rows` (b,), of whose vehicles about `share` (b,) are given."""
        crowd, first = self.moments.crowds(rows)
        every = np.arange(crowd.start[-1])
        group = crowd.group(every)
        within = every - first[group]
        given = (within * 0.61803398875 + 7 * share[group]) % 1.0 < share[group]  # spread evenly, another subset for each share
        given[first] = True
        shown = replace(crowd, there=crowd.there & given)
        around = Surroundings.of(self.lanes, shown, first, self.counts, 0.0)
        asked = np.flatnonzero(crowd.there & crowd.planned & ~given)
        return around.tensors(), _wanted(around, crowd, first, group[asked], asked)


def _wanted(
    around: Surroundings,
    crowd: Crowd,
    first: NDArray[np.integer],
    group: NDArray[np.integer],
    asked: NDArray[np.integer],
) -> Wanted:
    """The region of each vehicle `asked` (n,) of `group` (n,), one vehicle per region."""
    on, part, across, turned = _against(around.lanes[group], crowd.state[first[group]], crowd.state[asked])
    inside = on & around.lane_there[group]
    region = np.where(inside, np.abs(across), np.inf).argmin(axis=1)
    n = np.arange(len(asked))
    on_one = inside[n, region]
    _, single = np.unique(np.where(on_one, group * around.lanes.shape[1] + region, -1 - n), return_index=True)
    kept = np.zeros(len(asked), np.bool_)
    kept[single] = True
    kept &= on_one
    columns = [of_region[n, region] for of_region in (part, across, turned)]
    speed = np.hypot(crowd.state[asked, 3], crowd.state[asked, 4]) / 10
    attributes = np.column_stack([*columns, speed, crowd.size[asked, 0] / 5, crowd.size[asked, 1] / 2]).astype(np.float32)
    column = n - np.searchsorted(group, group)
    shape = len(first), int(column.max(initial=0)) + 1
    out = []
    for values in (region, kept, attributes, np.minimum(crowd.kind[asked], len(KINDS) - 1).astype(np.int64)):
        out.append(np.zeros((*shape, *values.shape[1:]), values.dtype))
        out[-1][group, column] = values
    return Wanted(*map(torch.from_numpy, out))


def _against(
    lanes: NDArray[np.float32], origin: NDArray[np.float32], state: NDArray[np.float32]
) -> tuple[NDArray[np.bool_], NDArray[np.floating], NDArray[np.floating], NDArray[np.floating]]:
    """(n, V) whether somebody is on each region, part of it passed, offset to its left [m], heading against it [rad]."""
    cos, sin = np.cos(origin[:, 2]), np.sin(origin[:, 2])
    dx, dy = state[:, 0] - origin[:, 0], state[:, 1] - origin[:, 1]
    x, y = (cos * dx + sin * dy)[:, None], (cos * dy - sin * dx)[:, None]
    begin, end = lanes[..., 0:2] * REACH, lanes[..., 2:4] * REACH
    ux, uy = lanes[..., 4], lanes[..., 5]
    gx, gy = x - begin[..., 0], y - begin[..., 1]
    turned = wrap_angle((state[:, 2] - origin[:, 2])[:, None] - np.arctan2(uy, ux))
    along, across, length = ux * gx + uy * gy, ux * gy - uy * gx, np.maximum(np.hypot(*np.moveaxis(end - begin, -1, 0)), 0.1)
    on = (along >= 0) & (along <= length) & (np.abs(across) < WITHIN) & (np.abs(turned) < AGREEING)
    return on, along / length, across, turned


def place(
    net: PlacementNet, scenario: Scenario, counts: tuple[int, int], piece: float, count: int, random: np.random.Generator
) -> Vehicles:
    """`count` vehicles in all, or as many as find room: the scenario's target, then those that are drawn around it.

    Of the scenario, map, target and signals at step 0 are read.
    """
    lanes = LaneVectors.of([scenario], piece)
    placed, used = scenario.vehicles[:1], np.zeros(counts[0], np.bool_)
    with torch.inference_mode():
        while len(placed) < count:
            crowd = _crowd(placed)
            around = Surroundings.of(lanes, crowd, np.zeros(1, np.int64), counts, 0.0)
            used |= ~around.lane_there[0]
            if len(placed) == 1:
                used |= _against(around.lanes, crowd.state, crowd.state)[0][0]
            regions = Regions(*(part[0].double() for part in net(*around.tensors())))
            fresh = _draw(regions, around.lanes[0], used, placed, random)
            if fresh is None:
                return placed
            placed = _with(placed, fresh)
    return placed


def _draw(
    regions: Regions, lanes: NDArray[np.float32], used: NDArray[np.bool_], placed: Vehicles, random: np.random.Generator
) -> Vehicles | None:
    """One more vehicle that overlaps nobody; regions in which all tries failed are `used` from then on. None if all are."""
    chance = torch.sigmoid(regions.odds).numpy() * ~used
    while chance.sum() > 0:
        region = int(random.choice(len(chance), p=chance / chance.sum()))
        used[region], chance[region] = True, 0.0
        for _ in range(TRIES):
            component = int(random.choice(COMPONENTS, p=_normalised(regions.weight[region].exp().numpy())))
            sigma = regions.sigma[region, component].exp().numpy()
            attributes = regions.mean[region, component].numpy() + sigma * random.standard_normal(ATTRIBUTES)
            kind = KINDS[int(random.choice(len(KINDS), p=_normalised(regions.kind[region].softmax(-1).numpy())))]
            fresh = _vehicle(lanes[region], attributes, kind, placed)
            hit = boxes_overlap(
                fresh.position, fresh.heading, fresh.size[:, :2] + 0.5, placed.position, placed.heading, placed.size[:, :2]
            )
            if not hit.any():
                return fresh
    return None


def _vehicle(lane: NDArray[np.float32], attributes: NDArray[np.float64], kind: VehicleKind, placed: Vehicles) -> Vehicles:
    """The vehicle of these attributes in a region, in the map's frame."""
    part, offset, turned, speed, length, width = attributes.tolist()
    begin, end, direction = lane[0:2] * REACH, lane[2:4] * REACH, np.arctan2(lane[5], lane[4])
    left = np.array([-np.sin(direction), np.cos(direction)])
    local = begin + (end - begin) * np.clip(part, 0, 1) + left * np.clip(offset, -WITHIN, WITHIN)
    heading, origin = float(placed.heading[TARGET]), placed.position[TARGET]
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    return Vehicles(
        track_id=np.array([f"placed-{len(placed)}"]),
        kind=np.array([kind], np.uint8),
        size=np.array([[np.clip(5 * length, 2.5, 18), np.clip(2 * width, 1.4, 2.6), HEIGHT]], np.float32),
        size_source=np.array([SizeSource.ASSUMED], np.uint8),
        position=(origin + turn @ local)[None].astype(np.float32),
        heading=np.array([wrap_angle(np.array(heading + direction + np.clip(turned, -1, 1)))], np.float32),
        speed=np.array([max(10 * speed, 0.0)], np.float32),
    )


def _with(placed: Vehicles, fresh: Vehicles) -> Vehicles:
    return Vehicles(*(np.concatenate([getattr(placed, f.name), getattr(fresh, f.name)]) for f in fields(Vehicles)))


def _crowd(placed: Vehicles) -> Crowd:
    velocity = unit(placed.heading) * placed.speed[:, None]
    state = np.column_stack([placed.position, placed.heading, velocity]).astype(np.float32)
    there, zero = np.ones(len(placed), np.bool_), np.zeros(1, np.int64)
    return Crowd(np.array([0, len(placed)]), zero, zero, state, there, there, placed.size[:, :2], placed.kind)


def _normalised(chance: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(chance / chance.sum())
