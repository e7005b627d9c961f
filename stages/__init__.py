"""Doors from DVC to the library: read a params section, take paths from argv, call `drivegen`, write."""
