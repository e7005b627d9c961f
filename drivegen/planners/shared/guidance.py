"""Guided sampling: a flow's latents are pushed towards motion of lower cost in the last steps of its integration.

At time t the end of the straight path, z + (1 - t) v, is decoded, its cost is differentiated by forward differences (motion
of a latent is no tensor), and z is moved down the gradient by a step of fixed length: guidance on the estimate of the clean
sample, as in diffusion (Dhariwal and Nichol 2021).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol, runtime_checkable

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from drivegen.core.scenario import Trajectories
from drivegen.core.settings import Count, Positive
from drivegen.planners.base import PlanRequests
from drivegen.planners.shared.flow import FlowNet
from drivegen.planners.shared.latent import in_chunks
from drivegen.planners.shared.noise import normals

Cost = Callable[[Trajectories, NDArray[np.intp]], NDArray[np.floating]]
"""Motion (M, T) and the request (M,) that each is of -> cost (M,)."""

NUDGE = 0.1
"""Latents are moved by this for a difference."""


@dataclass(frozen=True)
class Guidance:
    """`last`: steps of the integration that are guided. `inner`: pushes in each. `step`: length of a push, in latents."""

    last: Count
    inner: Count
    step: Positive


@runtime_checkable
class Guided(Protocol):
    """A planner whose latents can be seen."""

    net: FlowNet

    @property
    def size(self) -> int:
        """Z, of its latents."""

    @property
    def euler_steps(self) -> int:
        """Of its integration."""

    def inputs(self, requests: PlanRequests) -> NDArray[np.float32]:
        """(B, F) what the network is told."""

    def motion(self, requests: PlanRequests, latents: NDArray[np.float32], steps: int) -> Trajectories:
        """(B, steps) of latents (B, Z)."""


def guided(planner: Guided, requests: PlanRequests, steps: int, cost: Cost, guidance: Guidance) -> Trajectories:
    """Motion (B, steps) of requests (B,), pushed down `cost`."""
    euler, z = planner.euler_steps, normals(requests.seed, planner.size)
    context = in_chunks(planner.net, planner.net.context, planner.inputs(requests))
    for k in range(euler):
        velocity = in_chunks(planner.net, partial(_velocity, planner.net, k / euler), z, context)
        for _ in range(guidance.inner if k >= euler - guidance.last else 0):
            end = z + (1 - k / euler) * velocity
            z = z - guidance.step * _direction(planner, requests, end, steps, cost)
        z = z + velocity / np.float32(euler)
    return planner.motion(requests, z, steps)


def _velocity(net: FlowNet, time: float, latents: Tensor, context: Tensor) -> Tensor:
    return net.velocity(latents, torch.full((1,), time, device=latents.device), context)


def _direction(
    planner: Guided, requests: PlanRequests, latents: NDArray[np.float32], steps: int, cost: Cost
) -> NDArray[np.float32]:
    """(B, Z) unit vectors along which the cost rises most; zero where it does not change."""
    count, size = latents.shape
    nudges = np.concatenate([np.zeros((1, size)), NUDGE * np.eye(size)]).astype(np.float32)
    request = np.repeat(np.arange(count), size + 1)
    nudged = (latents[:, None] + nudges).reshape(-1, size)
    value = np.asarray(cost(planner.motion(requests[request], nudged, steps), request)).reshape(count, size + 1)
    slope = value[:, 1:] - value[:, :1]
    return np.asarray(slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-9), np.float32)
