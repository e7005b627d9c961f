"""Planning trajectories: both flows in large batches beside the paper's network. Speed does not depend on the weights."""

from collections.abc import Iterator

import numpy as np

from drivegen.bench import _scene
from drivegen.bench._row import Row, best_cpu_seconds
from drivegen.planners.base import Examples
from drivegen.planners.paper import PaperSettings
from drivegen.planners.paper import Plugin as Paper
from drivegen.planners.poly_fm import Plugin as PolyFm
from drivegen.planners.poly_fm import PolyFmSettings
from drivegen.planners.route_fm import Plugin as RouteFm
from drivegen.planners.route_fm import RouteFmSettings
from drivegen.planners.shared.requests import examples_from_logs
from drivegen.training.loop import Settings as Training

SCENES, SAMPLES = 16, 10
PAPER_REQUESTS = 32

_BARELY = Training(
    steps=1, batch=8, learning_rate=1e-4, warmup=0, decay=False, weight_decay=0.0, average=0.0, clip=1.0, bf16=False,
    report_every=1, checkpoint_every=1,
)  # fmt: skip
_ROUTE_FM = RouteFmSettings(along=10, across=6, width=192, blocks=3, dropout=0.0, draws=1, euler_steps=8, training=_BARELY)
_POLY_FM = PolyFmSettings(
    along=10, bend=8, tokens=64, heads=4, width=128, blocks=3, dropout=0.0, draws=1, euler_steps=8, training=_BARELY
)
_PAPER = PaperSettings(
    state="pose", tokens=100, width=256, heads=4, layers=3, noise_steps=100, schedule="cosine", target="noise", sampler="ddpm",
    sampling_steps=100, batch_of="trajectories", channels=("surface", "boundaries", "centrelines"), extent=100.0, bf16=False,
    training=_BARELY,
)  # fmt: skip


def rows() -> Iterator[Row]:
    """5000 trajectories per CPU-second are wanted; the paper's network takes its 100 steps for a single batch of 32."""
    scenes = [_scene.scene(number) for number in range(SCENES)]
    examples = examples_from_logs(scenes, [_scene.graph()] * SCENES, 0.8, _scene.SEED)
    moving = examples[np.flatnonzero(~examples.requests.parked)]
    many = np.tile(np.arange(len(moving)), SAMPLES)
    value = _per_second(RouteFm(_ROUTE_FM), moving, many, turns=3)
    reference = _per_second(Paper(_PAPER), moving, many[:PAPER_REQUESTS], turns=1)
    unit, other = "trajectories per CPU-second", "paper's network, 100 steps"
    yield Row("route_fm, 8 steps", value, unit, 5000, False, reference, other)
    yield Row("poly_fm, 8 steps", _per_second(PolyFm(_POLY_FM), moving, many, turns=3), unit, None, False, reference, other)


def _per_second(
    planner: RouteFm | PolyFm | Paper, examples: Examples, indices: "np.ndarray[tuple[int, ...], np.dtype[np.int64]]", turns: int
) -> float:
    planner.fit([examples], examples[:0], _scene.SEED, None, lambda _: None)
    requests = examples.requests[indices]
    return len(indices) / best_cpu_seconds(lambda: planner.sample(examples.scenarios, requests), turns)
