"""Settings that do not go together are refused in one sentence that names the parameter."""

from typing import Any

import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.core.settings import build, read_section

KINDS = {"train_planner.planners": "planners", "train_generator.generators": "generators", "train_driver.drivers": "drivers"}


def settings(section: str, changed: dict[str, Any]) -> Any:
    """Those of a section of params.yaml, some of them `changed`; names may be dotted."""
    values, (kind, name) = read_section(section), section.rsplit(".", 1)
    for dotted, value in changed.items():
        *outer, last = dotted.split(".")
        inner = values
        for word in outer:
            inner = inner[word]
        inner[last] = value
    plugin = plugins.load(KINDS[kind], name)
    return build(plugin.lessons_type() if KINDS[kind] == "drivers" else plugin.Settings, values, f"params.yaml: {section}")


@pytest.mark.parametrize(
    ("section", "changed", "sentence"),
    [
        ("train_planner.planners.route_fm", {"along": 9}, "along and across together must be a multiple of 2, not 15"),
        ("train_planner.planners.route_fm", {"across": 20}, "across must be between 1 and 19, not 20"),
        ("train_planner.planners.poly_fm", {"along": 9}, "along must be a multiple of 2, not 9"),
        ("train_planner.planners.poly_fm", {"bend": 20}, "bend must be between 1 and 19, not 20"),
        ("train_planner.planners.poly_fm", {"tokens": 66}, "tokens must be a multiple of heads, 4, not 66"),
        ("train_planner.planners.paper", {"width": 250}, "width must be a multiple of heads, 4, not 250"),
        ("train_planner.planners.paper", {"tokens": 99}, "tokens must be a multiple of 2, not 99"),
        ("train_planner.planners.paper", {"sampling_steps": 101}, "sampling_steps must be at most noise_steps, 100, not 101"),
        ("train_planner.planners.paper", {"schedule": "square"}, "schedule must be one of cosine, linear, not 'square'"),
        ("train_planner.planners.paper", {"channels": ["lanes"]}, "channels must be one of surface, .*, not 'lanes'"),
        ("train_generator.generators.bits", {"width": 40}, "width must be a multiple of 16, not 40"),
        ("train_generator.generators.bits", {"horizon": 42}, "horizon must be a multiple of 5, not 42"),
        ("train_generator.generators.bits", {"commit": 45}, "commit must be at most horizon, 40, not 45"),
        ("train_generator.generators.bits", {"temperature": 0.5}, "unknown name 'temperature'"),
        ("train_generator.generators.trafficgen", {"commit": 12}, "commit must be a multiple of 5, not 12"),
        ("train_generator.generators.trafficgen", {"commit": 55}, "commit must be at most horizon, 50, not 55"),
        ("train_generator.generators.scene_transformer", {"heads": 5}, "width must be a multiple of heads, 5, not 64"),
        ("train_generator.generators.scene_transformer", {"stretches": 3}, "stretches must be a divisor of 20, not 3"),
        ("train_generator.generators.scene_transformer", {"pieces": 257}, "pieces must be between 1 and 256, not 257"),
        ("train_generator.generators.lctgen", {"heads": 5}, "width must be a multiple of heads, 5, not 64"),
        ("train_generator.generators.lctgen", {"pieces": 257}, "pieces must be between 1 and 256, not 257"),
        ("train_driver.drivers.gail", {"ppo.discount": 1.0}, "ppo.discount must be between 0 and 0.9999, not 1.0"),
        ("train_driver.drivers.sac", {"environment.motion": "free"}, "environment.motion must be path, not 'free'"),
    ],
)
def test_what_does_not_go_together_is_refused(section: str, changed: dict[str, Any], sentence: str) -> None:
    settings(section, {})
    with pytest.raises(UnusableInput, match=sentence) as refusal:
        settings(section, changed)
    assert section in str(refusal.value)
    assert "\n" not in str(refusal.value)
