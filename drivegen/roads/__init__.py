"""The lane graph of a map: routes, coordinates along them, the drivable surface, and where the road ends."""
