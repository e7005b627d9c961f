"""Closed-loop simulators: a driver steers the target; the others are replayed or react, people are replayed. One file each."""
