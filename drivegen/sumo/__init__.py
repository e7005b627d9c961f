"""SUMO: its networks read, its traffic simulated and recorded, and its own closed loop. Alone here is libsumo imported."""
