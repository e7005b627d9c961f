"""Argoverse 2's Motion Forecasting layout: a folder `<name>` of its own."""

from pathlib import Path

from drivegen.av2.export import export_scenario
from drivegen.core.scenario import Scenario, Trajectories
from drivegen.exporters.base import About

ABOUT = About(title="Argoverse 2 Motion Forecasting", read_by="av2, drivegen view")


class Plugin:
    """Argoverse 2's layout."""

    def write(self, scenario: Scenario, motion: Trajectories, folder: Path, name: str) -> None:
        """See `base.Exporter`."""
        export_scenario(scenario, motion, folder, name)
