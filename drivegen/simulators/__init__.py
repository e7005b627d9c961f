"""Closed-loop simulators: a driver steers the target while social vehicles and people are replayed. One file each."""
