"""DriveGen-CS: what made a driver fail steers the goals of the next scenarios (paper, "DriveGen-CS"). No training."""
