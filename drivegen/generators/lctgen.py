"""LCTGen (Tan et al., CoRL 2023): a scenario code, and a query-based decoder that turns code and map into traffic.

As in the paper: a code of eight small numbers for each vehicle (quadrant, distance, direction, speed, four actions of the
future; `_lctgen.codes`), map pieces under multi-context gating, one query for each vehicle that attends to the other queries
and to the map, small networks that read off each query where the vehicle stands (which piece of road, and mixtures of
Gaussians for its place on it, heading, size and speed) and K' motions with their odds, the nearest of which is taught.

The table gives every method the first frame, so vehicles are not placed there, and four fields of the code are known. The
four actions are in the future: here they are drawn, one after the other, from a prior that was learnt on the train logs
and sees the first frame only. `lctgen_log_code` takes them from the log instead: an upper bound, no method.

Left out: the language model that writes a code, the map's own code, and the library of maps that it is retrieved from; the
tables give map and first frame. Reduced, by settings: width 64, not 256; fields of the code are looked up in tables, not as
sinusoids; one mixture for all attributes; a motion is a smooth curve of few degrees of freedom in each direction. Changed, to
its advantage: where the first frame is given, a query is also told its vehicle's exact state and the context of its
surroundings in its own frame; the future lasts 10 s, so an action lasts 2.5 s.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from drivegen.core import seeds
from drivegen.core.errors import UnusableInput
from drivegen.core.methods import Method
from drivegen.core.samples import Samples
from drivegen.core.scenario import TARGET, Scenario, Vehicles
from drivegen.core.settings import Count, NotNegative, Within, expect_multiple
from drivegen.generators._lctgen.codes import PARTS, Action, logged_actions, logged_code, state_code
from drivegen.generators._lctgen.learning import LctgenObjective, Taught, Trainable, around_targets
from drivegen.generators._lctgen.net import LctgenNet
from drivegen.generators._lctgen.place import place
from drivegen.generators.shared.learned import Learned, Placement
from drivegen.generators.shared.motion import filled_in, trajectories
from drivegen.generators.shared.vectors import AGENTS, PIECES, Scenes
from drivegen.training import loop

ABOUT = Method(
    title="LCTGen",
    line="A scenario code, and queries that turn code and map into traffic (Tan et al., CoRL 2023).",
    kind="learned",
    goals=None,
    trains_on="the logs",
    places=True,
    additions=(),
)

CHUNK = 16
"""Scenes that go through the network at once, always: sums differ between batch sizes."""


@dataclass(frozen=True)
class LctgenSettings:
    """Values stand in params.yaml, `train_generator.generators.lctgen`.

    Attributes:
        width, heads, layers: of the transformer of queries; `width` is a multiple of `heads`. blocks: of context gating.
        modes: K' motions of each query.
        gaussians: of a placed vehicle's attributes. pieces: of road that each vehicle sees in its own frame.
        placement: weight of the placement in the loss.
        training: see `training.loop.Settings`.
    """

    width: Count
    heads: Count
    layers: Count
    blocks: Count
    modes: Count
    gaussians: Count
    pieces: Annotated[int, Within(1, PIECES)]
    placement: NotNegative
    training: loop.Settings

    def __post_init__(self) -> None:
        expect_multiple("train_generator.generators.lctgen.width", self.width, self.heads, "heads")


class Plugin(Learned):
    """See the module. `label` is the method's name in what it makes."""

    name = label = "lctgen"
    tempered = True
    about = ABOUT
    Settings = LctgenSettings
    Examples = Taught

    net: Trainable

    @classmethod
    def network(cls, settings: LctgenSettings) -> nn.Module:
        """See `Learned`."""
        s = settings
        return Trainable(LctgenNet(s.width, s.heads, s.layers, s.blocks, s.modes, s.gaussians, s.pieces))

    @classmethod
    def examples(cls, settings: LctgenSettings, scenarios: Sequence[Scenario]) -> Taught:
        """See `Learned`."""
        del settings
        return Taught.of(scenarios)

    @classmethod
    def objective(cls, settings: LctgenSettings, net: nn.Module, train: Taught, validation: Taught, seed: int) -> loop.Objective:
        """See `Learned`."""
        del net, seed
        return LctgenObjective(train, validation, settings.placement)

    def generate(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> list[Samples]:
        """K futures of each scenario, the vehicles' drawn apart from one another."""
        made: list[Samples] = []
        for low in range(0, len(scenarios), CHUNK):
            chunk = scenarios[low : low + CHUNK]
            scenes = Scenes.of(chunk).padded(CHUNK)
            with torch.inference_mode():
                knots = self._knots(scenes, *self._noise(chunk, samples, seed), self.known_actions(chunk))
            for row, scenario in enumerate(chunk):
                dense = filled_in(knots[row], scenes.speed[row])
                motion = trajectories(scenario, *(x[:, : len(scenario.vehicles)] for x in dense))
                made.append(Samples.without_goals(scenario.scenario_id, self.label, motion))
        return made

    def known_actions(self, scenarios: Sequence[Scenario]) -> NDArray[np.int64] | None:
        """Actions (CHUNK, A, PARTS) that are not to be drawn: none, as the future is not known."""
        del scenarios
        return None

    def place(self, scenario: Scenario, code: NDArray[np.int64], rng: np.random.Generator) -> Vehicles:
        """The scenario's target and vehicles drawn for the further rows of a code (N, 8); see `_lctgen.place`."""
        return place(self.net.net, scenario, code, rng)

    def placements(self, logs: Iterable[Scenario], seed: int) -> dict[str, Placement]:
        """By the code of one of `logs`, as nobody knows the right one; and, a bound, by that of the scenario's own log.

        Of its target the code says what the first frame does: how fast it is counts for those around it.
        """
        library = [logged_code(log) for log in logs]

        def placed(scenario: Scenario, own: bool) -> Vehicles:
            rng, count = seeds.rng(seed, self.name, "place", own, scenario.scenario_id), len(scenario.vehicles)
            fit = [code for code in library if len(code) >= count] or library
            code = (logged_code(scenario) if own else fit[int(rng.integers(len(fit)))])[:count].copy()
            target = state_code(around_targets([scenario]))[0, TARGET]
            code[TARGET, : len(target)] = target
            return self.place(scenario, code, rng)

        title = self.about.title
        bound = {f"{title}, code from the log (a bound, no method)": lambda scenario: placed(scenario, True)}
        return ({f"{title}, code of a training log": lambda scenario: placed(scenario, False)} if library else {}) | bound

    def bounds(self) -> dict[str, Learned]:
        """Told the log's actions."""
        return {LogCode.label: LogCode._with(self.settings, self.net)}

    def _noise(self, scenarios: Sequence[Scenario], samples: int, seed: int) -> tuple[Tensor, Tensor]:
        """Gumbel noise for actions (CHUNK, K, A, PARTS, 8) and modes (CHUNK, K, A, K'), none beyond the scenarios."""
        shapes = (PARTS, len(Action)), (self.settings.modes,)
        noises = [torch.zeros(CHUNK, samples, AGENTS, *shape) for shape in shapes]
        for row, scenario in enumerate(scenarios):
            rng = seeds.rng(seed, self.name, scenario.scenario_id)
            for noise in noises:
                noise[row] = torch.from_numpy(rng.gumbel(size=noise.shape[1:]))
        return noises[0], noises[1]

    def _knots(
        self, scenes: Scenes, action_noise: Tensor, mode_noise: Tensor, given: NDArray[np.int64] | None
    ) -> NDArray[np.float32]:
        """Knots (CHUNK, K, A, J, 2) in the vehicles' frames."""
        net, inputs = self.net.net, scenes.tensors(torch.device("cpu"))
        roads, vehicles, state = net.roads(inputs), net.vehicles(inputs), torch.from_numpy(state_code(scenes))
        drawn = []
        for k in range(mode_noise.shape[1]):
            actions = self._actions(vehicles, action_noise[:, k]) if given is None else torch.from_numpy(given)
            decoded = net.decoded(inputs, roads, torch.cat([state, actions], dim=-1), vehicles)
            knots, logits = net.moved(inputs, decoded)
            mode = (logits / self.temperature + mode_noise[:, k]).argmax(-1)
            index = mode[..., None, None, None].expand(*mode.shape, 1, *knots.shape[-2:])
            drawn.append(knots.gather(2, index)[:, :, 0])
        return np.asarray(torch.stack(drawn, dim=1).numpy())

    def _actions(self, vehicles: Tensor, noise: Tensor) -> Tensor:
        """Actions (CHUNK, A, PARTS) drawn part after part by Gumbel's trick."""
        actions = torch.zeros(noise.shape[:-1], dtype=torch.int64)
        for part in range(PARTS):
            logits = self.net.net.action_logits(vehicles, actions, part) / self.temperature
            actions[..., part] = (logits + noise[..., part, :]).argmax(-1)
        return actions


class LogCode(Plugin):
    """Told what every vehicle will do: looks at the log, and says so."""

    label = "lctgen_log_code"
    backend = "recorded"

    def known_actions(self, scenarios: Sequence[Scenario]) -> NDArray[np.int64]:
        """The log's actions; KEEP_SPEED where it did not see any. Raises UnusableInput for a scenario without a log."""
        for scenario in scenarios:
            if scenario.log is None:
                raise UnusableInput(f"scenario {scenario.scenario_id} was never recorded: there is no action to take from it")
        actions, seen = logged_actions(Scenes.with_logs(scenarios).padded(CHUNK))
        return np.where(seen, actions, Action.KEEP_SPEED)
