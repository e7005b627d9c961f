"""What a description leaves open: drawn from its own random stream, rounded, and said."""

from drivegen import seeds
from drivegen.maps.writers._facts import Facts

KMH = 1 / 3.6

_SPEEDS = {"residential": 30 * KMH, "rural": 80 * KMH, "urban": 50 * KMH, "": 50 * KMH}
_ARTERIAL_SPEED = 60 * KMH
_HIGHWAY_SPEED = 120 * KMH


class Choices:
    """Numbers for what is unsaid; the same text and seed give the same ones, whatever else is asked for."""

    def __init__(self, text: str, seed: int) -> None:
        self._text, self._seed = text, seed
        self.assumed: list[str] = []
        self.waived: list[float] = []  # lengths [m] that were said and could not be kept, which `assumed` tells

    def length(self, what: str, low: int, high: int, step: int = 10) -> float:
        """A length [m] between `low` and `high`, a multiple of `step`."""
        steps = (high - low) // step
        metres = low + step * int(seeds.rng(self._seed, "maps", self._text, what).integers(steps + 1))
        self.assume(f"{what} {metres} m")
        return float(metres)

    def assume(self, what: str) -> None:
        """Note something that was not said."""
        if what not in self.assumed:
            self.assumed.append(what)

    def lanes(self, facts: Facts, usual: int, *roles: str) -> int:
        """Lanes per direction of the road: of the first role that is known, else the first number without a role."""
        for role in roles:
            if role in facts.lanes:
                return facts.lanes[role]
        if facts.other_lanes:
            return min(facts.other_lanes)[1]
        self.assume(f"{usual} lane{'s' if usual > 1 else ''} per direction")
        return usual

    def speed(self, facts: Facts, highway: bool = False) -> float:
        """Speed limit of the main road [m/s]."""
        if "main" in facts.speeds:
            return facts.speeds["main"]
        usual = _SPEEDS[facts.surroundings]
        if facts.has("arterial") and not facts.surroundings:
            usual = _ARTERIAL_SPEED
        if highway:
            usual = _HIGHWAY_SPEED
        self.assume(f"speed limit {usual / KMH:.0f} km/h")
        return usual
