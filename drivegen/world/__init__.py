"""The world that a driver drives in: others who are replayed or react, signals, rules, collisions. Batched, on a torch device."""
