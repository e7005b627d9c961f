"""What several drivers, and environments for training them, have in common."""
