"""Typed road layouts (specifications without coordinates) and the SUMO networks that they compile to."""
