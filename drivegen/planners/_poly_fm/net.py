"""poly_fm's encoder: what is known of a request asks the pieces of lane around it (cross-attention), twice."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core.scenario import DT
from drivegen.planners._poly_fm.bends import poses
from drivegen.planners._poly_fm.polylines import MOST, PIECE
from drivegen.planners.base import PlanRequests
from drivegen.planners.shared.paths import bezier_paths

OWN = 24
"""Numbers that a request says of itself; the pieces of lane follow them in a row of features."""

FEATURES = OWN + MOST * PIECE
"""F, the width of the network's input."""


def own_features(requests: PlanRequests) -> NDArray[np.float32]:
    """(B, OWN) float32: goal and speeds in the vehicle's frame, and how they fit the time that is given."""
    start, goal = poses(requests)
    away = goal[:, :2] - start[:, :2]
    cos, sin = np.cos(start[:, 2]), np.sin(start[:, 2])
    ahead, left = cos * away[:, 0] + sin * away[:, 1], cos * away[:, 1] - sin * away[:, 0]
    turn = goal[:, 2] - start[:, 2]
    length = bezier_paths(start, goal)[1]
    duration = np.maximum(requests.goal_step, 1) * DT
    mean, first, last = length / duration, requests.speed.astype(np.float64), requests.goal_speed.astype(np.float64)
    chord = np.hypot(ahead, left)
    columns = [
        ahead / 50, left / 20, np.tanh(ahead / 10), np.tanh(left / 3), np.cos(turn), np.sin(turn),
        ahead / (chord + 1), left / (chord + 1), first / 10, last / 10, mean / 10, length / 50, np.log1p(length) / 3,
        duration / 10, (first - mean) / 5, (last - mean) / 5, first / (first + last + 1), np.exp(-first), np.exp(-last),
        np.tanh(first * duration / (length + 1) / 4), np.tanh(last * duration / (length + 1) / 4), length / (chord + 1) - 1,
        requests.size[:, 0] / 5 - 1, requests.size[:, 1] / 2 - 1,
    ]  # fmt: skip
    return np.column_stack(columns).astype(np.float32)


class PolylineEncoder(nn.Module):
    """Features (B, FEATURES) to (B, width): every piece of lane is a token, made by a small network of its own points.

    The request is the one query, so the cost grows with the number of pieces and not with its square.
    """

    def __init__(self, tokens: int, heads: int, width: int, dropout: float) -> None:
        super().__init__()
        self.own = nn.Sequential(nn.Linear(OWN, width), nn.SiLU(), nn.Linear(width, tokens))
        self.piece = nn.Sequential(nn.Linear(PIECE, tokens), nn.SiLU(), nn.Linear(tokens, tokens), nn.SiLU())
        self.asked = nn.ModuleList(_Ask(tokens, heads) for _ in range(2))
        self.leave = nn.Sequential(nn.Linear(tokens + OWN, width), nn.SiLU(), nn.Dropout(dropout))

    def forward(self, features: Tensor) -> Tensor:
        """(B, width)."""
        own, pieces = features[:, :OWN], features[:, OWN:].view(-1, MOST, PIECE)
        tokens, there = self.piece(pieces), pieces[..., -1] > 0
        query = self.own(own)
        for ask in self.asked:
            query = ask(query, tokens, there)
        return torch.as_tensor(self.leave(torch.cat([query, own], dim=-1)))


class _Ask(nn.Module):
    """One round of attention of a query (B, W) over tokens (B, M, W), and a feed-forward network."""

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.norms = nn.ModuleList(nn.LayerNorm(width) for _ in range(2))
        self.query, self.pair, self.join = nn.Linear(width, width), nn.Linear(width, 2 * width), nn.Linear(width, width)
        self.forward_net = nn.Sequential(nn.Linear(width, 2 * width), nn.SiLU(), nn.Linear(2 * width, width))

    def forward(self, query: Tensor, tokens: Tensor, there: Tensor) -> Tensor:
        """(B, W); `there` (B, M) says which tokens count. Without any, the query learns nothing from the map."""
        count, most, width = tokens.shape
        asks = self.query(self.norms[0](query)).view(count, self.heads, 1, -1)
        key, value = self.pair(tokens).view(count, most, 2, self.heads, -1).permute(2, 0, 3, 1, 4)
        score = (asks @ key.transpose(-1, -2)) / key.shape[-1] ** 0.5
        weight = score.masked_fill(~there[:, None, None], -1e4).softmax(dim=-1) * there[:, None, None]
        query = query + self.join((weight @ value).reshape(count, width))
        return torch.as_tensor(query + self.forward_net(self.norms[1](query)))
