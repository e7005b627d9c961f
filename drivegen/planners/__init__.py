"""Trajectory planners, one file each: from an initial state and a goal to motion like a human's."""
