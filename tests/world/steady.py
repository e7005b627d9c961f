"""A driver of whom everything is known beforehand, for tests of what happens to it."""

from drivegen.world.observation import Action


class Steady:
    """Keeps its speed, or its acceleration, whatever happens; moves to `offset`."""

    name = "steady"

    def __init__(self, offset=None, acceleration=0.0):
        self.offset, self.acceleration = offset, acceleration

    def act(self, observation):
        offset = None if self.offset is None else self.offset + 0 * observation.speed
        return Action(self.acceleration + 0 * observation.speed, offset)
