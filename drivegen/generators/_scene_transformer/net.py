"""The network: attention factorised over agents and time, with the road beside it, and F joint futures (see the plugin)."""

import torch
from torch import Tensor, nn

from drivegen.generators.shared.attention import Block, mlp
from drivegen.generators.shared.motion import KNOTS, Onward
from drivegen.generators.shared.relative import OTHER_FEATURES, Surroundings, SurroundingsEncoder, surroundings
from drivegen.generators.shared.vectors import SceneTensors


class SceneTransformerNet(nn.Module):
    """Tokens (scene, agent, stretch of time): the present one is told the first frame, the future ones are hidden.

    `modes` F futures; `pieces` of road around each agent; the future is cut into `stretches` of equal length, one token
    each.
    """

    def __init__(self, width: int, heads: int, layers: int, decoder_layers: int, modes: int, stretches: int, pieces: int) -> None:
        super().__init__()
        self.pieces, self.modes, self.stretches = pieces, modes, stretches
        self.around = SurroundingsEncoder(width)
        self.hidden = nn.Parameter(0.02 * torch.randn(1 + stretches, width))
        self.mode = nn.Parameter(0.5 * torch.randn(modes, width))
        self.relation = mlp(OTHER_FEATURES, width // 2, heads)
        self.to_road = nn.ModuleList([Block(width, heads) for _ in range(layers)])
        self.over_time = nn.ModuleList([Block(width, heads) for _ in range(layers + decoder_layers)])
        self.over_agents = nn.ModuleList([Block(width, heads) for _ in range(layers + decoder_layers)])
        self.out = nn.Sequential(nn.LayerNorm(width), nn.Linear(width, 2 * KNOTS // stretches))
        self.onward = Onward()
        self.score = mlp(width, width, 1, normed=True)

    def forward(self, scenes: SceneTensors) -> tuple[Tensor, Tensor]:
        """Knots (S, F, A, J, 2) [m] in each vehicle's frame, and logits (S, F) of the joint futures."""
        seen = surroundings(scenes, self.pieces)
        things = self.around(seen)
        bias = self.relation(seen.other).permute(0, 3, 1, 2)  # (S, heads, A, A)
        x = self._encoded(scenes, seen, things, bias)
        x = x[:, None] + self.mode[:, None, None]
        for time, agents in list(zip(self.over_time, self.over_agents, strict=True))[len(self.to_road) :]:
            x = agents(time(x).transpose(2, 3), there=scenes.present[:, None, None], bias=bias[:, None, None]).transpose(2, 3)
        weight = scenes.present[:, None, :, None].to(x)
        pooled = (x.mean(dim=3) * weight).sum(dim=2) / weight.sum(dim=2).clamp_min(1)
        added = self.out(x[..., 1:, :]).reshape(*x.shape[:-2], KNOTS, 2)
        return self.onward(scenes.speed[:, None], added), self.score(pooled)[..., 0]

    def _encoded(self, scenes: SceneTensors, seen: Surroundings, things: Tensor, bias: Tensor) -> Tensor:
        """Tokens (S, A, 1 + stretches, width) that know the scene, the same for all futures."""
        pieces, agents = self.pieces, scenes.present.shape[1]
        own = things[:, :, pieces : pieces + agents].diagonal(dim1=1, dim2=2).transpose(1, 2)
        x = own[:, :, None] + self.hidden
        for road, time, across in zip(self.to_road, self.over_time, self.over_agents, strict=False):
            x = time(road(x, things, seen.there))
            x = across(x.transpose(1, 2), there=scenes.present[:, None], bias=bias[:, None]).transpose(1, 2)
        return x
