"""Attention over any one axis of a tensor, with masks and relations between pairs (Vaswani et al. 2017)."""

from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.functional import scaled_dot_product_attention


def mlp(*sizes: int, normed: bool = False) -> nn.Sequential:
    """Linear layers from size to size with GELU between them, behind a normalisation if `normed`."""
    layers: list[nn.Module] = [nn.LayerNorm(sizes[0])] if normed else []
    for given, wanted in pairwise(sizes):
        layers += [nn.Linear(given, wanted), nn.GELU()]
    return nn.Sequential(*layers[:-1])


class Attention(nn.Module):
    """Multi-head attention from queries (..., Q, width) to things (..., K, width)."""

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.query = nn.Linear(width, width)
        self.key_value = nn.Linear(width, 2 * width)
        self.out = nn.Linear(width, width)

    def forward(self, queries: Tensor, things: Tensor, there: Tensor | None = None, bias: Tensor | None = None) -> Tensor:
        """(..., Q, width). `there` (..., K) masks things; `bias` (..., heads, Q, K) is added to the scores.

        Every row must have a thing that is there.
        """
        query = self._split(self.query(queries))
        key, value = (self._split(x) for x in self.key_value(things).chunk(2, dim=-1))
        if there is not None:
            absent = torch.zeros_like(there, dtype=query.dtype).masked_fill(~there, -1e4)[..., None, None, :]
            bias = absent if bias is None else bias + absent
        attended = scaled_dot_product_attention(query, key, value, attn_mask=bias)
        mixed: Tensor = self.out(attended.transpose(-3, -2).flatten(-2))
        return mixed

    def _split(self, x: Tensor) -> Tensor:
        return x.reshape(*x.shape[:-1], self.heads, -1).transpose(-3, -2)


class Block(nn.Module):
    """Attention and a feed-forward network, each after a normalisation and beside a shortcut."""

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.before, self.between = nn.LayerNorm(width), nn.LayerNorm(width)
        self.attention = Attention(width, heads)
        self.feed = mlp(width, 2 * width, width)

    def forward(self, x: Tensor, things: Tensor | None = None, there: Tensor | None = None, bias: Tensor | None = None) -> Tensor:
        """x (..., Q, width) after attending to `things` (already normalised), or to one another where there are none."""
        normal = self.before(x)
        x = x + self.attention(normal, normal if things is None else things, there, bias)
        fed: Tensor = self.feed(self.between(x))
        return x + fed
