"""Scenario generators, one file each: DriveGen, its ablations and everything it is compared with."""
