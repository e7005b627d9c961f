"""The parts of generator `trafficgen`: vectors around a vehicle, networks, what is learnt, placement."""
