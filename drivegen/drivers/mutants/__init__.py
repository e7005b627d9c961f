"""Drivers made worse on purpose, each by one stated fault, and drivers that do the same by another way."""
