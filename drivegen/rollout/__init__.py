"""Scenario rollout: goals drawn, motion planned, legality checked, the illegal planned again; models and shipping."""
