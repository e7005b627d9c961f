"""A listwise ranker: a score for each candidate of a list, seen against the list as a whole; softmax over the scores."""

import torch
from torch import Tensor, nn


class Ranker(nn.Module):
    """Two layers per candidate, the list's mean and maximum beside them (Zaheer et al., "Deep Sets"), two more layers."""

    mean: Tensor
    scale: Tensor
    temperature: Tensor

    def __init__(self, features: int, width: int, dropout: float = 0.0) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(features))
        self.register_buffer("scale", torch.ones(features))
        self.register_buffer("temperature", torch.ones(()))
        drop = nn.Dropout(dropout)  # of no weight, so that weights load whatever it was
        self.each = nn.Sequential(nn.Linear(features, width), nn.SiLU(), drop, nn.Linear(width, width), nn.SiLU(), drop)
        self.scored = nn.Sequential(nn.Linear(3 * width, width), nn.SiLU(), drop, nn.Linear(width, 1))

    def forward(self, x: Tensor, there: Tensor) -> Tensor:
        """Log probabilities (B, MOST) before tempering, of lists x (B, MOST, F) with candidates where `there` (B, MOST)."""
        hidden = self.each(((x - self.mean) / self.scale).clamp(-5, 5))
        count = there.sum(1, keepdim=True).clamp(min=1)
        mean = (hidden * there[..., None]).sum(1) / count
        most = hidden.masked_fill(~there[..., None], -1e4).amax(1)
        whole = torch.cat([mean, most], -1)[:, None].expand(-1, x.shape[1], -1)
        score = self.scored(torch.cat([hidden, whole], -1))[..., 0]
        return torch.log_softmax(score.masked_fill(~there, -1e4), -1)
