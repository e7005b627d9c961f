"""Processor time."""

import resource
import time


def cpu_seconds() -> float:
    """What this process, in all its threads, and its children that ended have taken so far."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
