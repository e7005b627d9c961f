"""First frames: which vehicles stand where, how fast and of what size, on any map, as recorded traffic has them."""
