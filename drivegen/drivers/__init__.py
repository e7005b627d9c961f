"""Driving algorithms under test, one file each; `base.py` says what they see and what they answer."""
