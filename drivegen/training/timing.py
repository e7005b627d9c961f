"""What training and planning take: processor time, and wall time where there is a GPU."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from drivegen.training import loop


@contextmanager
def timed(what: str, costs: dict[str, float]) -> Iterator[None]:
    """Add to `costs` what the block takes [s]: `<what>_cpu_seconds` and, on a GPU, `<what>_gpu_seconds` (wall time)."""
    cpu, wall = time.process_time(), time.perf_counter()
    yield
    costs[f"{what}_cpu_seconds"] = costs.get(f"{what}_cpu_seconds", 0.0) + time.process_time() - cpu
    if loop.device().type == "cuda":
        costs[f"{what}_gpu_seconds"] = costs.get(f"{what}_gpu_seconds", 0.0) + time.perf_counter() - wall
