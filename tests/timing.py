"""CPU time in units of the machine that runs the test, so that a limit holds on a slow machine as on a fast one."""

import gc
import time
from collections.abc import Callable


def cpu_seconds(task: Callable[[], object], times: int = 1) -> float:
    """The least CPU seconds of so many runs of the task, without garbage collection, as `timeit` measures.

    A collection walks what all tests before this one left in the process, which says nothing of the task.
    """

    def once() -> float:
        began = time.process_time()
        task()
        return time.process_time() - began

    collects = gc.isenabled()
    gc.disable()
    try:
        return min(once() for _ in range(times))
    finally:
        if collects:
            gc.enable()


def yardstick() -> float:
    """CPU seconds of a fixed piece of plain Python: about 0.1 s on the machine on which limits were set."""
    return cpu_seconds(lambda: sum(number % 7 for number in range(2_000_000)), times=3)
