"""The parts of generator `smart`: tokens of motion, what a vehicle sees, the network, what is learnt, driving on."""
