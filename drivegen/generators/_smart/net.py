"""SMART's network: attention over a vehicle's last tokens, over the road and over the others, and odds of the next token."""

from typing import NamedTuple

import torch
from torch import Tensor, nn

from drivegen.core.scenario import DT
from drivegen.generators._smart.around import OTHER_FEATURES
from drivegen.generators._smart.tokens import CODE, RADIUS, SPAN
from drivegen.generators.shared.attention import mlp
from drivegen.generators.shared.lanes import LANE_FEATURES, PACE, REACH

OWN_FEATURES = 11
"""Speed, length, width, seconds since the first frame, whether this is the first frame, kind (one-hot)."""

PAST_FEATURES = 5
"""Place, direction and age of a vehicle's own earlier token."""

AGE = 10.0
"""Seconds since the first frame, and tokens back, that are told as 1."""

NEVER = -1e4
"""Logit of a token that is not drawn."""

SHARP = 1.6
"""Logarithm of how fast odds fall with the squared distance [1 / m2] from what is expected, before anything is learnt."""


class Seen(NamedTuple):
    """What V vehicles see at T moments, a token of the network each; the moments before are `Past`.

    Attributes:
        token: (V, T) int64 the motion that led here. own: (V, T, OWN_FEATURES).
        pose: (V, T, 3) x, y [m], heading [rad], of the map, and used in differences alone.
        fresh: (V, T) bool the first frame of a vehicle: it remembers nothing before it.
        road: (V, T, R, LANE_FEATURES), road_there: (V, T, R).
        other: (V, T, K, OTHER_FEATURES), other_there: (V, T, K), who: (V, T, K) int64 the row of each, 0 .. V - 1, or -1.
    """

    token: Tensor
    own: Tensor
    pose: Tensor
    fresh: Tensor
    road: Tensor
    road_there: Tensor
    other: Tensor
    other_there: Tensor
    who: Tensor


class Past(NamedTuple):
    """Earlier moments: poses (V, P, 3), fresh (V, P), and what each layer knew then, (V, P, width) each."""

    pose: Tensor
    fresh: Tensor
    context: list[Tensor]


class Look(nn.Module):
    """Multi-head attention of each token (..., width) to things of its own (..., K, width).

    Keys and values are whole matrices per head that are taken to the side of the query, where there are K times fewer.
    """

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.heads, self.scale = heads, width**-0.5
        self.query, self.out = nn.Linear(width, heads * width), nn.Linear(heads * width, width)

    def forward(self, x: Tensor, things: Tensor, there: Tensor) -> Tensor:
        """(..., width); `there` (..., K)."""
        query = self.query(x).unflatten(-1, (self.heads, -1))
        score = (query @ things.transpose(-1, -2) * self.scale).masked_fill(~there[..., None, :], -1e4)
        attended: Tensor = self.out((score.softmax(dim=-1) @ things).flatten(-2))
        return attended


class Layer(nn.Module):
    """The token's own past, the road, the others, each beside a shortcut, and a feed-forward network."""

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.norms = nn.ModuleList([nn.LayerNorm(width) for _ in range(4)])
        self.looks = nn.ModuleList([Look(width, heads) for _ in range(3)])
        self.feed = mlp(width, 4 * width, width)

    def forward(
        self, x: Tensor, seen: Seen, codes: tuple[Tensor, ...], context: Tensor, back: Tensor, there: Tensor
    ) -> tuple[Tensor, Tensor]:
        """x (V, T, width), and what is known (V, P + T, width) after `context` (V, P, width) of earlier moments.

        `codes` of how past, road and others lie; `back`, `there`: see `SmartNet._remembered`.
        """
        normal = self.norms[0](x)
        context = torch.cat([context, normal], dim=1)
        x = x + self.looks[0](normal, context[:, back] + codes[0], there)
        x = x + self.looks[1](self.norms[1](x), codes[1], seen.road_there)
        normal, moment = self.norms[2](x), torch.arange(x.shape[1], device=x.device)[:, None]
        theirs = torch.where((seen.who >= 0)[..., None], normal[seen.who.clamp_min(0), moment], 0.0)
        x = x + self.looks[2](normal, theirs + codes[2], seen.other_there)
        x = x + self.feed(self.norms[3](x))
        return x, context


class SmartNet(nn.Module):
    """`tokens` W of `width`; `layers` of `heads`; each token remembers `memory` of its own, itself included."""

    way: Tensor
    code: Tensor

    def __init__(self, tokens: int, width: int, heads: int, layers: int, memory: int) -> None:
        super().__init__()
        self.memory = memory
        self.register_buffer("way", torch.zeros(tokens, SPAN, 3))
        self.register_buffer("code", torch.zeros(tokens, CODE))
        self.word, self.told = mlp(CODE, width, width), nn.Linear(OWN_FEATURES, width)
        self.begin = nn.Parameter(0.02 * torch.randn(width))
        self.past, self.road = mlp(PAST_FEATURES, width, width), mlp(LANE_FEATURES, width, width)
        self.other = mlp(OTHER_FEATURES, width, width)
        self.layers = nn.ModuleList([Layer(width, heads) for _ in range(layers)])
        self.head = mlp(width, 2 * width, width, normed=True)
        self.answer, self.expected = mlp(CODE, width, width), nn.Linear(width, CODE + 1)
        nn.init.zeros_(self.expected.weight)
        nn.init.zeros_(self.expected.bias)

    def forward(self, seen: Seen, past: Past | None = None) -> tuple[Tensor, Past]:
        """Logits (V, T, W) of the next token, and what the moments after these will remember."""
        first = Past(seen.pose[:, :0], seen.fresh[:, :0], []) if past is None else past
        pose, fresh = torch.cat([first.pose, seen.pose], dim=1), torch.cat([first.fresh, seen.fresh], dim=1)
        back, there = self._remembered(fresh, seen.token.shape[1])
        codes = self.past(_between(seen.pose, pose[:, back])), self.road(seen.road), self.other(seen.other)
        moving = torch.where(seen.fresh[..., None], self.begin, self.word(self.code)[seen.token])
        x, context = moving + self.told(seen.own), []
        for number, layer in enumerate(self.layers):
            x, now = layer(x, seen, codes, first.context[number] if first.context else x[:, :0], back, there)
            context.append(now)
        kept = max(self.memory - 1, 1)
        return self._odds(x, seen), Past(pose[:, -kept:], fresh[:, -kept:], [part[:, -kept:] for part in context])

    @property
    def spare(self) -> Tensor:
        """(W,) tokens that only fill the vocabulary: they repeat the first one, to stand still, and are never drawn."""
        repeated = (self.way == self.way[:1]).all(dim=(1, 2))
        return repeated & (torch.arange(len(repeated), device=repeated.device) > 0)

    def _odds(self, x: Tensor, seen: Seen) -> Tensor:
        """Logits (V, T, W): any, and beside them odds that fall with the distance from the motion that is expected.

        That is the last one again, or straight on in the first frame, and what the network adds to it.
        """
        free = self.head(x) @ self.answer(self.code).T * x.shape[-1] ** -0.5
        added, sharp = self.expected(x).split([CODE, 1], dim=-1)
        again = torch.where(seen.fresh[..., None], _straight_on(seen.own[..., 0]), self.code[seen.token]) + added
        near = 2 * again @ self.code.T - self.code.square().sum(dim=1)
        odds: Tensor = free + (sharp + SHARP).exp() * near
        return odds.masked_fill(self.spare, NEVER)

    def _remembered(self, fresh: Tensor, moments: int) -> tuple[Tensor, Tensor]:
        """Of each of the last T moments, which (T, memory) it looks back at, itself first, and (V, T, memory) whether it may."""
        before = fresh.shape[1] - moments
        wanted = torch.arange(before, before + moments, device=fresh.device)[:, None]
        wanted = wanted - torch.arange(self.memory, device=fresh.device)
        begun = torch.where(fresh, torch.arange(fresh.shape[1], device=fresh.device), 0).cummax(dim=1).values[:, before:]
        return wanted.clamp_min(0), wanted >= begun[..., None]


def _straight_on(speed: Tensor) -> Tensor:
    """(..., CODE) of going straight on at `speed` (...) in units of PACE."""
    way = speed[..., None] * (torch.arange(1, SPAN + 1, device=speed.device) * (DT * PACE))
    zero = torch.zeros_like(way)
    code: Tensor = torch.stack([way, zero, zero + RADIUS, zero], dim=-1).flatten(-2) * SPAN**-0.5
    return code


def _between(pose: Tensor, earlier: Tensor) -> Tensor:
    """(V, T, memory, PAST_FEATURES) of `earlier` poses (V, T, memory, 3) as they are seen from `pose` (V, T, 3)."""
    gap, turn = earlier[..., :2] - pose[:, :, None, :2], earlier[..., 2] - pose[:, :, None, 2]
    cos, sin = pose[:, :, None, 2].cos(), pose[:, :, None, 2].sin()
    along, left = cos * gap[..., 0] + sin * gap[..., 1], cos * gap[..., 1] - sin * gap[..., 0]
    age = torch.arange(gap.shape[2], device=gap.device).expand_as(along) / AGE
    return torch.stack([along / REACH, left / REACH, turn.cos(), turn.sin(), age], dim=-1)
