"""Our own suite of traffic in words: how much of what is asked for is understood, placed and done, and what it costs.

Every request stands in `suite.json` with what it means, written by hand. Its first frame is rolled out twice: under the words,
and with the selector's own goals. The difference in illegal vehicles, and the probability that the selector itself gives to the
goals that the words demand, are the price in realism.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.resources import files
from typing import Any

import numpy as np
import orjson
from numpy.typing import NDArray

from drivegen.asked.account import Item, first_frame, manoeuvres
from drivegen.asked.start import AskedStart, Settings, start
from drivegen.core.errors import UnusableInput
from drivegen.core.roadmap import RoadMap
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET
from drivegen.generators.base import Settings as GeneratorSettings
from drivegen.placement.gaps import gaps_of
from drivegen.placement.scenes import Initialiser
from drivegen.placement.ways import Ways, turns
from drivegen.rollout.batch import roll_out
from drivegen.rollout.choices import Choices
from drivegen.rollout.models import Equipment
from drivegen.words.request import TrafficRequest

LEFT_TURN = np.deg2rad(35)
"""A piece of a way across a junction that bends to the left by more than this belongs to a left turn [rad]."""


@dataclass(frozen=True)
class Request:
    """One request.

    Attributes:
        text, means: its words, and what they mean. road: what it must offer: "any", "lanes" side by side, a "junction" with ways
            that bend to the left, or a "crossing", where one turns left before those who come the other way (a ring has none).
    """

    text: str
    means: TrafficRequest
    road: str


def suite() -> list[Request]:
    """All requests."""
    rows = orjson.loads(files("drivegen.asked").joinpath("suite.json").read_bytes())
    return [Request(row["text"], TrafficRequest.model_validate(row["means"]), row["road"]) for row in rows]


def offers(road_map: RoadMap) -> set[str]:
    """What a map has of what requests need."""
    names = {"any"}
    if road_map.may_change.any():
        names.add("lanes")
    if any(_turn(road_map.centreline[lane]) > LEFT_TURN for lane in np.flatnonzero(road_map.in_junction).tolist()):
        names.add("junction")
    if turns(road_map, Ways(road_map))[:, 0].any():
        names.add("crossing")
    return names


def _turn(line: NDArray[np.float32]) -> float:
    step = np.diff(line.astype(np.float64), axis=0)
    heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    return float(heading[-1] - heading[0])


def as_meant(read: TrafficRequest, means: TrafficRequest) -> bool:
    """Whether a request was read as it was meant; the order of groups and rounding of units don't matter."""
    return _plain(read) == _plain(means)


def _plain(request: TrafficRequest) -> tuple[Any, ...]:
    groups = sorted(
        tuple(round(v, 2) if isinstance(v, float) else v for v in group.model_dump(mode="json").values()).__repr__()
        for group in request.groups
    )
    speeds = [None if speed is None else round(speed, 2) for speed in (request.speed, request.target_speed)]
    return (groups, request.density, *speeds, request.target_kind, request.target_does)


@dataclass(frozen=True)
class Bench:
    """What requests are tried with: `read` turns words into a request, `vehicles` in all where none are said."""

    read: Callable[[str], TrafficRequest]
    settings: Settings
    generation: GeneratorSettings
    tools: Equipment
    vehicles: int
    samples: int
    seed: int

    def row(self, request: Request, name: str, initialiser: Initialiser) -> dict[str, Any]:
        """One request on one map: what was understood, what was got, what it cost.

        What was got is measured against the reading, item by item; a misreading, or none, counts as one more item that was not
        got, so that things which nobody read are not counted one by one.
        """
        try:
            read, reason = self.read(request.text), ""
        except UnusableInput as error:
            read, reason = TrafficRequest(), error.reason
        meant = as_meant(read, request.means)
        row = {"text": request.text, "map": name, "read_as_meant": meant, "reason": reason}
        lost = [] if meant else [Item("misread", "what the words mean", False)] * self.samples
        if not read or not request.means:
            return {**row, "items": [asdict(item) for item in lost]}
        made = start(
            initialiser, f"asked-{name}", read, self.settings, self.vehicles, self.tools.selector, self.generation, self.seed
        )
        bound, free = self._rolled(made.ordered.choices), self._rolled(made.free)
        return {**row, **self._told(read, made, bound, free, lost)}

    def _rolled(self, choices: Choices) -> Samples:
        return roll_out(
            [choices], self.tools.planner, self.tools.limits, self.generation.rollout, self.samples, self.seed, "asked"
        )[0]

    def _told(
        self, read: TrafficRequest, made: AskedStart, bound: Samples, free: Samples, lost: Sequence[Item]
    ) -> dict[str, Any]:
        items = [item for k in range(self.samples) for item in self._first_frame(read, made, ~bound.dropped[k])]
        done = [manoeuvres(made, bound, k) for k in range(self.samples)]
        by_chance = [manoeuvres(made, free, k) for k in range(self.samples)]
        return {
            "vehicles": len(made.scenario.vehicles),
            "asked_vehicles": len(made.cast),
            "rejected": dict(made.rejected),
            "items": [asdict(item) for item in [*items, *lost]],
            "manoeuvres": [[asdict(item) for item in sample] for sample in done],
            "unasked_manoeuvres": [[asdict(item) for item in sample] for sample in by_chance],
            "illegal": _lost_share(bound),
            "illegal_free": _lost_share(free),
            "least_time_gap": _least_time_gap(made),
        }

    def _first_frame(self, read: TrafficRequest, made: AskedStart, present: NDArray[np.bool_]) -> list[Item]:
        """What is got at the first frame of those whom a future (N,) has; nothing where it lacks its target."""
        items = first_frame(read, made.only(np.flatnonzero(present)) if present[TARGET] else made, self.settings.densities)
        return [replace(item, got=item.got and bool(present[TARGET])) for item in items]


def _lost_share(samples: Samples) -> float:
    """Share of vehicles that broke a rule or were dropped because nothing legal was found."""
    return float(((samples.violation > 0) | samples.dropped).mean())


def _least_time_gap(made: AskedStart) -> float | None:
    """The smallest time gap [s] at the first frame; None where nobody that moves has a leader."""
    rows = [row for row in gaps_of(made.scenario) if np.isfinite(row["gap"]) and row["speed"] > 1.0]
    return min((float(row["gap"] / row["speed"]) for row in rows), default=None)


def summary(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Counts of all rows, and success with its price for each kind of request."""
    kinds: dict[str, list[tuple[bool, bool | None, float | None, Mapping[str, Any]]]] = {}
    for row in rows:
        for item in row["items"]:
            kinds.setdefault(item["kind"], []).append((item["got"], None, None, row))
        for done, by_chance in zip(row.get("manoeuvres", []), row.get("unasked_manoeuvres", []), strict=True):
            for item, other in zip(done, by_chance, strict=True):
                kinds.setdefault(item["kind"], []).append((item["got"], other["got"], item["natural"], row))
    placed = [row for row in rows if "vehicles" in row]
    everything = [got for group in kinds.values() for got, *_ in group]
    return {
        "scenes": len(rows),
        "read_as_meant": sum(row["read_as_meant"] for row in rows),
        "got": float(np.mean(everything)) if everything else 0.0,
        "vehicles_asked": sum(row["asked_vehicles"] for row in placed),
        "vehicles_placed": sum(row["vehicles"] for row in placed),
        "illegal": float(np.mean([row["illegal"] for row in placed])) if placed else 0.0,
        "illegal_free": float(np.mean([row["illegal_free"] for row in placed])) if placed else 0.0,
        "kinds": {kind: _rates(group) for kind, group in sorted(kinds.items())},
    }


def scene_records(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """For the record: what `rows` say of each scene, by the name of its map and the words, and the share of items got in it."""
    return {f"{row['map']}: {row['text']}": {**row, **_got("items_got", row["items"])} for row in rows}


def sample_records(rows: Sequence[Mapping[str, Any]], sample: int) -> dict[str, dict[str, Any]]:
    """The same of one sample of each scene: the share of manoeuvres that were driven in it."""
    with_samples = [row for row in rows if "manoeuvres" in row]
    return {f"{row['map']}: {row['text']}": _got("manoeuvres_got", row["manoeuvres"][sample]) for row in with_samples}


def _got(name: str, items: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    return {name: float(np.mean([item["got"] for item in items]))} if items else {}


def _rates(rows: Sequence[tuple[bool, bool | None, float | None, Mapping[str, Any]]]) -> dict[str, Any]:
    """Of one kind of request; `by_chance` is how often it came about in the same scene without being asked for."""
    chance = [other for _, other, _, _ in rows if other is not None]
    natural = [mass for _, _, mass, _ in rows if mass is not None]
    gaps = [row["least_time_gap"] for *_, row in rows if row.get("least_time_gap") is not None]
    return {
        "asked": len(rows),
        "got": float(np.mean([got for got, *_ in rows])),
        "by_chance": float(np.mean(chance)) if chance else None,
        "natural": float(np.median(natural)) if natural else None,
        **{name: _mean([row[name] for *_, row in rows if name in row]) for name in ("illegal", "illegal_free")},
        "least_time_gap": float(np.median(gaps)) if gaps else None,
    }


def _mean(numbers: Sequence[float]) -> float | None:
    return float(np.mean(numbers)) if numbers else None
