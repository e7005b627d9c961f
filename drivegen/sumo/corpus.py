"""Simulated logs for machines without data: a prepared network in, a number of scenario windows out.

"SUMO corpus (simulated)" wherever it is named. The networks' own demand is replaced by random trips and their own
signal programs by fixed-time ones: several of those that come with SUMO hold a phase for an hour.
"""

from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from drivegen.core import seeds
from drivegen.core.crop import Cropper
from drivegen.core.errors import UnusableInput
from drivegen.core.scenario import DT, Scenario
from drivegen.core.settings import Count, NotNegative, Positive, Share
from drivegen.core.signals import Signals
from drivegen.sumo.bends import with_human_speeds
from drivegen.sumo.demand import Demand, draw_demand, mean_limit, vehicles_at_begin
from drivegen.sumo.netconvert import convert
from drivegen.sumo.network import Network
from drivegen.sumo.parking import ParkingSettings, park, with_parked
from drivegen.sumo.sensing import SensingSettings, sensed
from drivegen.sumo.traffic import Run, Traffic, simulate
from drivegen.sumo.windows import EGO, Recording, WindowSettings, cut_windows, moves

_BARREN_RUNS = 16
"""A network that gives no scenario in this many runs one after the other is given up."""

_VEHICLES_PER_SCENARIO = 14
"""About so many vehicles on a network give one scenario per window: decides how long the first run is, nothing else."""

FAST = 20.0
"""[m/s]"""

_CYCLES = (50, 60, 70, 80, 90)
"""Cycle times of signals [s]."""


@dataclass(frozen=True)
class CorpusSettings:
    """How logs are simulated.

    Attributes:
        most_vehicles: bound on the vehicles at the beginning of a run.
        warm_up: [s] before recording begins. most_windows_per_run: windows one after the other in a run, at most.
        lateral_resolution: width of a sublane [m].
        fast_density: as `density` of `simulate_scenarios`, on networks whose mean limit is above FAST: from free flow to jams.
        exit_speed: least and most of a run, see `Demand`.
        time_limit: processor time that one run may take [s].
        parking: who is parked beside the streets. window: which windows make scenarios. sensing: how they are measured.
        without_signals: share of the runs whose recordings tell nobody what signals show.
    """

    most_vehicles: Count
    warm_up: NotNegative
    most_windows_per_run: Count
    lateral_resolution: Positive
    fast_density: tuple[float, ...]
    exit_speed: tuple[float, ...]
    time_limit: Positive
    parking: ParkingSettings
    window: WindowSettings
    sensing: SensingSettings
    without_signals: Share


def prepare_network(raw: bytes, city: str, seed: int) -> bytes:
    """The network with limits that suit its bends and fixed-time programs at every signal, cycle time drawn by `seed`.

    Raises UnusableInput where the file is no network that netconvert accepts.
    """
    Network.read(raw, city)  # netconvert must not be the first to parse it
    cycle = seeds.rng(seed, "signals", city).choice(_CYCLES)
    files = {"in.net.xml.gz" if raw[:2] == b"\x1f\x8b" else "in.net.xml": raw}
    rebuild = ["--tls.rebuild", "true", "--tls.default-type", "static", "--tls.cycle.time", str(cycle)]
    plain = ["--offset.disable-normalization", "true", "--output.street-names", "false", "--no-warnings", "true"]
    built = convert(files, ["-s", next(iter(files)), *rebuild, *plain, "-o", "out.net.xml"], "out.net.xml")
    return with_human_speeds(built, city)


def simulate_scenarios(
    raw: bytes, city: str, part: int, count: int, density: tuple[float, float], settings: CorpusSettings, seed: int
) -> list[Scenario]:
    """`count` scenarios on the prepared network `raw`, the same ones for the same city, part, settings and seed.

    Each run begins with a number of vehicles per kilometre of lane drawn from `density` (least, most). The sum of `per_hour` over
    all that are returned is how many scenarios, overlapping ones too, an hour of the network's traffic holds; the last window in
    time may have been cut short.
    Raises UnusableInput where the network yields too few.
    """
    network = Network.read(raw, city)
    cropper = Cropper(network.map)
    least, most = settings.fast_density if mean_limit(network) > FAST else density
    scenarios: list[Scenario] = []
    barren = run = windows_seen = 0
    share = 1.0 / _VEHICLES_PER_SCENARIO
    while len(scenarios) < count:
        random = seeds.rng(seed, "corpus", city, part, run)
        missing = count - len(scenarios)
        vehicles = vehicles_at_begin(network, random.uniform(least, most), settings.most_vehicles)
        windows = int(np.clip(np.ceil(missing / (vehicles * share)), 1, settings.most_windows_per_run))
        traffic = _drive(raw, network, vehicles, windows, settings, random)
        recording = Recording(network, traffic, cropper, city)
        cut = list(islice(cut_windows(recording, f"{city}-{part:03d}-{run:02d}", settings.window, random), missing))
        windows_seen += cut[-1][0] + 1 if len(cut) == missing else windows
        parked = park(network, traffic, settings.parking, seeds.rng(seed, "parked", city, part, run))
        shown = [with_parked(window, parked, network.map.origin, settings.window.radius) for _, window in cut]
        scenarios += _recorded(shown, settings, random)
        share = max(len(cut) / (windows * vehicles), share / 4)  # what this network really gives
        barren, run = (0 if cut else barren + 1), run + 1
        if barren == _BARREN_RUNS:
            raise UnusableInput(f"{city}: the network gives no scenario in {barren} runs: take another", reason="no-scenarios")
    return [replace(scenario, per_hour=scenario.per_hour / windows_seen) for scenario in scenarios]


def _recorded(windows: list[Scenario], settings: CorpusSettings, random: np.random.Generator) -> list[Scenario]:
    """The windows of one run as they are recorded: by chance measured with errors, by chance without what signals show."""
    measured, silent = random.uniform(size=2) < (settings.sensing.share, settings.without_signals)
    if measured:
        windows = [sensed(window, EGO, settings.sensing, random) for window in windows]
    return [replace(window, signals=Signals.none(window.steps)) if silent else window for window in windows]


def _drive(
    raw: bytes, network: Network, vehicles: int, windows: int, settings: CorpusSettings, random: np.random.Generator
) -> Traffic:
    """One run of some windows, with random demand that begins with so many vehicles."""
    seconds = windows * settings.window.steps * DT
    demand = draw_demand(
        network,
        Demand(vehicles, random.uniform(settings.exit_speed[0], settings.exit_speed[1]), settings.warm_up + seconds),
        random,
    )
    run = Run(int(random.integers(2**31)), settings.warm_up, seconds, settings.lateral_resolution, settings.time_limit)
    return simulate(raw, demand, network.map.origin, run)


def moving_vehicles(scenarios: list[Scenario]) -> tuple[int, int]:
    """How many vehicles and riders of the scenarios move (see `windows.moves`), and how many there are."""
    tracks = [np.concatenate([moves(s.log), moves(s.context.motion)]) for s in scenarios if s.log is not None]
    return sum(int(track.sum()) for track in tracks), sum(len(track) for track in tracks)
