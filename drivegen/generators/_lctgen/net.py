"""The network: context gating over the map, a transformer of vehicle queries, heads for placement and motion."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from drivegen.generators._lctgen.codes import PARTS, SIZES, Action
from drivegen.generators.shared.attention import Block, mlp
from drivegen.generators.shared.motion import KNOTS, Onward
from drivegen.generators.shared.pieces import FEATURES, POINTS
from drivegen.generators.shared.relative import REACH, SurroundingsEncoder, surroundings
from drivegen.generators.shared.vectors import AGENT_FEATURES, AGENTS, SceneTensors

ATTRIBUTES = 6
"""Of a placed vehicle: along and across its piece of road [5 m], heading from the piece's [rad], length, width [5 m],
speed [10 m/s]."""


class ContextGating(nn.Module):
    """Multi-context gating (Varadarajan et al., MultiPath++): elements and one context of them gate one another."""

    def __init__(self, width: int, blocks: int) -> None:
        super().__init__()
        self.first = nn.Parameter(torch.ones(width))
        self.elements = nn.ModuleList([nn.Sequential(nn.Linear(width, width), nn.GELU()) for _ in range(blocks)])
        self.contexts = nn.ModuleList([nn.Sequential(nn.Linear(width, width), nn.GELU()) for _ in range(blocks)])

    def forward(self, x: Tensor, there: Tensor) -> tuple[Tensor, Tensor]:
        """Elements (..., K, width), gated, and their context (..., width); each block adds to the mean of those before."""
        context = self.first.expand(*x.shape[:-2], -1)
        for block, (element, gate) in enumerate(zip(self.elements, self.contexts, strict=True)):
            gated = element(x) * gate(context)[..., None, :]
            pooled = torch.where(there[..., None], gated, -1e4).amax(dim=-2).clamp_min(-1e3)
            x = x + (gated - x) / (block + 2)
            context = context + (pooled - context) / (block + 2)
        return x, context


@dataclass(frozen=True)
class Placement:
    """Where vehicles stand: logits (S, A, M) over pieces of road, and G Gaussians each of the ATTRIBUTES.

    Attributes:
        piece: (S, A, M). weight: (S, A, G) logits. mean, log_scale: (S, A, G, ATTRIBUTES).
    """

    piece: Tensor
    weight: Tensor
    mean: Tensor
    log_scale: Tensor


class LctgenNet(nn.Module):
    """`modes` K' futures of each vehicle; `gaussians` of each placed one; `pieces` of road around each vehicle."""

    def __init__(self, width: int, heads: int, layers: int, blocks: int, modes: int, gaussians: int, pieces: int) -> None:
        super().__init__()
        self.pieces, self.modes, self.gaussians = pieces, modes, gaussians
        self.line = mlp(2 * POINTS + FEATURES, width, width)
        self.map_gating = ContextGating(width, blocks)
        self.around = SurroundingsEncoder(width)
        self.own_gating = ContextGating(width, blocks)
        self.state = nn.Linear(AGENT_FEATURES, width)
        self.code = nn.ModuleList([nn.Embedding(size, width) for size in SIZES])
        self.query = nn.Parameter(0.02 * torch.randn(AGENTS, width))
        self.among = nn.ModuleList([Block(width, heads) for _ in range(layers)])
        self.to_map = nn.ModuleList([Block(width, heads) for _ in range(layers)])
        self.prior = mlp(2 * width + PARTS * (len(Action) + 1), width, len(Action))
        self.motion = mlp(width, 2 * width, modes * 2 * KNOTS, normed=True)
        self.onward = Onward()
        self.score = mlp(width, width, modes, normed=True)
        self.query_mask, self.map_mask = nn.Linear(width, width), nn.Linear(width, width)
        self.attributes = mlp(width, 2 * width, gaussians * (1 + 2 * ATTRIBUTES), normed=True)

    def roads(self, scenes: SceneTensors) -> Tensor:
        """The map's pieces (S, M, width) in the target's frame, gated by their context."""
        raw = torch.cat([scenes.points.flatten(-2) / REACH, scenes.piece], dim=-1)
        gated: Tensor = self.map_gating(self.line(raw), scenes.drawn)[0]
        return gated

    def vehicles(self, scenes: SceneTensors) -> Tensor:
        """What each vehicle (S, A, 2 width) is and sees: its state, and the context of its surroundings in its own frame."""
        seen = surroundings(scenes, self.pieces)
        _, context = self.own_gating(self.around(seen), seen.there)
        return torch.cat([self.state(scenes.agent), context], dim=-1)

    def action_logits(self, vehicles: Tensor, actions: Tensor, part: int) -> Tensor:
        """The prior's logits (..., A, 8) of the action in `part`, given those before it in `actions` (..., A, PARTS)."""
        drawn_actions = nn.functional.one_hot(actions, len(Action) + 1).to(vehicles)
        drawn_actions = drawn_actions * (torch.arange(PARTS, device=drawn_actions.device) < part)[:, None]
        logits: Tensor = self.prior(torch.cat([vehicles, drawn_actions.flatten(-2)], dim=-1))
        return logits

    def decoded(self, scenes: SceneTensors, roads: Tensor, code: Tensor, vehicles: Tensor | None) -> Tensor:
        """Queries (S, A, width) after the transformer; `vehicles` None where they are yet to be placed."""
        x: Tensor = self.query + torch.stack([table(code[..., field]) for field, table in enumerate(self.code)]).sum(0)
        if vehicles is not None:
            state, context = vehicles.chunk(2, dim=-1)
            x = x + state + context
        for among, to_map in zip(self.among, self.to_map, strict=True):
            x = to_map(among(x, there=scenes.present), roads, scenes.drawn)
        return x

    def moved(self, scenes: SceneTensors, decoded: Tensor) -> tuple[Tensor, Tensor]:
        """Knots (S, A, K', J, 2) [m] in each vehicle's frame, and logits (S, A, K') of the modes."""
        added = self.motion(decoded).reshape(*decoded.shape[:-1], self.modes, KNOTS, 2)
        return self.onward(scenes.speed[..., None], added), self.score(decoded)

    def placed(self, decoded: Tensor, roads: Tensor) -> Placement:
        """Where the queries' vehicles stand."""
        piece = torch.einsum("saw,smw->sam", self.query_mask(decoded), self.map_mask(roads)) / decoded.shape[-1] ** 0.5
        raw = self.attributes(decoded).reshape(*decoded.shape[:-1], self.gaussians, 1 + 2 * ATTRIBUTES)
        return Placement(piece, raw[..., 0], raw[..., 1 : 1 + ATTRIBUTES], raw[..., 1 + ATTRIBUTES :].clamp(-5.0, 2.0))
