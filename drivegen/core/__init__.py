"""What everybody stands on: scenarios, road maps, trajectories, samples, geometry, seeds, settings, errors, plugins."""
