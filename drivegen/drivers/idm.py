"""The Intelligent Driver Model (Treiber, Hennecke, Helbing 2000), the paper's third driving algorithm.

    a = a_max (1 - (v / v0)^delta - (s* / s)^2),   s* = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a_max b)))

v0 is the road's speed limit, or `desired_speed` where it has none. The leader is the nearest box ahead on the path that
reaches into the target's way, or will within `look_ahead`. A lower limit v1 ahead is
taken as SUMO does: as a leader that stands where it begins, s0 = 0, but no nearer than s*(v1), so that v1 is reached there.
Where it heeds rules, a line that it must not cross now is a leader that stands there: a red light; a yellow one and somebody with
right of way whom it would make brake, if it can still stop comfortably; a stop sign until it has halted.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import torch
from torch import Tensor

from drivegen.core.roadmap import LaneControl
from drivegen.core.settings import Within
from drivegen.core.signals import SignalState
from drivegen.world.observation import Action, Observation, Rules

_NO_GAP = 0.001
_CREEPS = 3.0  # [m/s] who is slower is taken to reach a line at this speed: it will speed up
_CLEARS = 1.0  # [s] who is gone so long before it is in nobody's way
_COMFORTABLE = 2.0  # times the comfortable braking: harder than that it does not stop for yellow or for others
_LIMIT_DISTANCES = torch.arange(2.0, 120.0, 6.0)

_Positive = Annotated[float, Within(0.001, 1000)]
_NotNegative = Annotated[float, Within(0, 1000)]
"""Of settings: a driver of others would ask for what is no number."""


@dataclass(frozen=True)
class Settings:
    """Parameters of the model.

    Attributes:
        desired_speed: [m/s] where the road has no limit. headway: T [s]. min_gap: s0 [m].
        acceleration: a_max [m/s2]. braking: comfortable b [m/s2]. emergency_braking: the most that is possible [m/s2].
        exponent: delta.
        side_margin: distance that a box beside the way must keep not to count as on it [m].
        look_ahead: time for which crossing vehicles are extrapolated [s]; 0 sees only who is on the way already.
        heeds_rules: whether it stops at lights and, if it also `gives_way`, at signs and for who has right of way.
        accepted_gap: [s] to whoever has right of way.
    """

    desired_speed: _Positive
    headway: _NotNegative
    min_gap: _NotNegative
    acceleration: _Positive
    braking: _Positive
    emergency_braking: _Positive
    exponent: _Positive
    side_margin: _NotNegative
    look_ahead: _NotNegative
    heeds_rules: bool
    gives_way: bool
    accepted_gap: _NotNegative


class Plugin:
    """IDM along the path, at the path's speed limits."""

    name = "idm"
    settings_type: ClassVar[type] = Settings

    def __init__(self, settings: Settings) -> None:
        self.settings = settings

    def act(self, observation: Observation) -> Action:
        """Follow the leader, the limits ahead or the desired speed, whichever asks for least."""
        settings, speed = self.settings, observation.speed
        limit = observation.speed_limit.nan_to_num(settings.desired_speed)
        free = 1 - (speed / limit) ** settings.exponent
        gap, leader_speed = self._leader(observation)
        desired_gap = settings.min_gap + self._dynamic_gap(speed, leader_speed)
        behind = (desired_gap / gap) ** 2
        if settings.heeds_rules and observation.rules is not None:
            line = self._line(observation.rules, speed)
            behind = torch.maximum(behind, ((settings.min_gap + self._dynamic_gap(speed, 0.0)) / line) ** 2)
        distance = _LIMIT_DISTANCES.to(speed)
        slower = observation.limits_ahead(distance).nan_to_num(settings.desired_speed)
        room = torch.maximum(distance, self._dynamic_gap(slower, 0.0))
        slowing = torch.where(slower < speed[:, None], (self._dynamic_gap(speed, 0.0)[:, None] / room) ** 2, 0.0).amax(dim=1)
        acceleration = settings.acceleration * (free - torch.maximum(behind, slowing))
        return Action(acceleration.clamp_min(-settings.emergency_braking))

    def _dynamic_gap(self, speed: Tensor, leader_speed: Tensor | float) -> Tensor:
        """s* - s0: the gap that is wanted to a leader beyond the minimal one [m]."""
        comfort = 2 * (self.settings.acceleration * self.settings.braking) ** 0.5
        gap: Tensor = speed * self.settings.headway + speed * (speed - leader_speed) / comfort
        return gap.clamp_min(0.0)

    def _leader(self, observation: Observation) -> tuple[Tensor, Tensor]:
        """Gap (S,) to the nearest box ahead [m], inf if none, and its speed (S,) along the path [m/s]."""
        reach = observation.half_width + (0.5 * observation.width + self.settings.side_margin)[:, None]
        now = observation.left - observation.offset[:, None]
        later = now + observation.speed_across * self.settings.look_ahead
        sweeps = (now * later <= 0) | (torch.minimum(now.abs(), later.abs()) < reach)
        ahead = observation.present & sweeps & (observation.ahead > 0)
        gaps = (observation.ahead - observation.half_length - 0.5 * observation.length[:, None]).clamp_min(_NO_GAP)
        gap, nearest = torch.where(ahead, gaps, torch.inf).min(dim=1)
        return gap, observation.speed_along.gather(1, nearest[:, None])[:, 0]

    def _line(self, rules: Rules, speed: Tensor) -> Tensor:
        """Distance (S,) to a line that must not be crossed now [m], inf if none."""
        settings, distance = self.settings, rules.distance.clamp_min(_NO_GAP)
        reached = distance / speed.clamp_min(_CREEPS)
        meets = (rules.arrives < reached[:, None] + settings.accepted_gap) & (rules.arrives > reached[:, None] - _CLEARS)
        green = rules.signal == SignalState.GREEN
        comfortable = distance > speed**2 / (2 * _COMFORTABLE * settings.braking)
        possible = distance > speed**2 / (2 * settings.emergency_braking)
        meets = meets & settings.gives_way
        waits = comfortable & (meets.any(1) | (rules.signal == SignalState.YELLOW))
        stops = (rules.control == LaneControl.STOP) & ~rules.halted & ~green & settings.gives_way
        held = possible & ((rules.signal == SignalState.RED) | stops | waits)
        return torch.where(held & (rules.distance > -_NO_GAP), distance, torch.inf)

    @property
    def sees_rules(self) -> bool:
        """Whether worlds have to look for rules ahead."""
        return self.settings.heeds_rules

    @property
    def desired_speed(self) -> float:
        """Speed on roads without a limit [m/s]."""
        return self.settings.desired_speed

    def vehicle_type(self) -> dict[str, str]:
        """SUMO's own IDM with the same parameters."""
        settings = self.settings
        return {
            "carFollowModel": "IDM",
            "accel": str(settings.acceleration),
            "decel": str(settings.braking),
            "emergencyDecel": str(settings.emergency_braking),
            "tau": str(settings.headway),
            "minGap": str(settings.min_gap),
            "delta": str(settings.exponent),
            "speedFactor": "1",
            "speedDev": "0",
            "maxSpeed": "70",
        }
