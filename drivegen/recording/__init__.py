"""Recordings of scenarios for the Rerun viewer."""

from drivegen.recording.record import GoalMarks, record_scenario

__all__ = ["GoalMarks", "record_scenario"]
