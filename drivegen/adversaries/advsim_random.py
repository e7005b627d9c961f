"""AdvSim's perturbations, drawn at random: what its search is worth."""

from dataclasses import replace

from drivegen.adversaries import advsim
from drivegen.adversaries.base import About

ABOUT = About(
    title="AdvSim, random",
    traffic="generated",
    varies="motions",
    source="Wang and others, AdvSim, CVPR 2021",
    stand_in="its perturbations, without a search",
)


class Plugin(advsim.Plugin):
    """See the module; `rounds` is 1 whatever the settings say."""

    def __init__(self, settings: advsim.Settings) -> None:
        super().__init__(replace(settings, rounds=1))
