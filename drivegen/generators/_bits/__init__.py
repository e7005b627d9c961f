"""The parts of generator `bits`: rasters, networks, what is learnt, rules."""
