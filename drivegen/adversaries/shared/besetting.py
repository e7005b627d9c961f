"""How attackers fare where vehicles beset the target, beside scenes in which they are placed as always."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from drivegen.adversaries.shared.findings import Findings
from drivegen.core.intervals import bootstrap_means
from drivegen.core.seeds import rng

PLACED = {"as always": False, "besetting": True}
METRICS = ("counted", "avoidable", "legal_share", "survives_reaction")
"""Shares of scenes; the last two of cases."""


class Attack(NamedTuple):
    """Who attacked whom, in scenes placed in which way (`PLACED`)."""

    driver: str
    placed: str
    method: str


def besetting_rows(found: Mapping[Attack, Sequence[tuple[str, Findings]]], draws: int, seed: int) -> Iterator[dict[str, Any]]:
    """Of every attack, given as (map, findings there): means with 95 % over maps, and the number of kinds of cases."""
    for attack, parts in found.items():
        pooled = Findings.joined([part for _, part in parts])
        maps = [name for name, part in parts for _ in part.scenarios]
        columns = np.column_stack([pooled.metrics[name] for name in METRICS])
        about = {**attack._asdict(), "n": len(columns)}
        for metric, interval in zip(METRICS, bootstrap_means(columns, maps, draws, rng(seed, "beset", "bootstrap")), strict=True):
            yield {**about, "metric": metric, **asdict(interval)}
        yield {**about, "metric": "kinds", "value": len(set(pooled.kinds)), "low": None, "high": None}
