"""Road maps: specifications built into networks and examined, networks of other programs read, maps written."""
