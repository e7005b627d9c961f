"""Generators that were trained for a few steps on hand-made scenes, to be looked at in tests."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

from drivegen.core import plugins
from drivegen.core.scenario import Scenario
from drivegen.core.settings import build, read_section
from drivegen.generators.shared.learned import Learned
from drivegen.training.curve import LossRow
from tests.models import two_lanes
from tests.scenes import busy_crossing

ROOT = Path(__file__).parents[2]


def scenes() -> list[Scenario]:
    """Different numbers of vehicles and lengths."""
    return [busy_crossing(101, "crossing-a"), two_lanes(9.0, "lanes-b", 81), busy_crossing(61, "crossing-c")]


def fitted(name: str, steps: int, rolled: Callable[[Learned], float] | None = None) -> tuple[Learned, list[LossRow]]:
    """The generator `name` after a few steps on `scenes`, with four rows of its curve."""
    values = read_section(f"train_generator.generators.{name}", ROOT / "params.yaml")
    if "training" in values:
        values["training"] |= {"steps": steps, "batch": 16, "warmup": 2, "report_every": steps // 4, "checkpoint_every": steps}
    plugin = plugins.load("generators", name)
    settings = build(plugin.Settings, values, "tests")
    logs = plugin.examples(settings, scenes())
    made: tuple[Learned, list[LossRow]] = plugin.fit(settings, logs, logs, 7, None, lambda _: None, rolled)
    return made


@cache
def trained(name: str, steps: int = 12) -> tuple[Learned, float, float]:
    """The generator and its training loss at the beginning and at the end."""
    generator, curve = fitted(name, steps)
    return generator, curve[0].train, curve[-1].train


def same(one: list, other: list) -> bool:
    """Whether two lists of samples move alike, bit by bit."""
    names = ("position", "heading", "velocity", "valid")
    return all((getattr(a.motion, n) == getattr(b.motion, n)).all() for a, b in zip(one, other, strict=True) for n in names)
