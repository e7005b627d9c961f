"""Recordings of scenarios for the Rerun viewer."""

from drivegen.recording.compare import LOG, record_comparison
from drivegen.recording.record import GoalMarks, record_scenario

__all__ = ["LOG", "GoalMarks", "record_comparison", "record_scenario"]
