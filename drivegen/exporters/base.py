"""The protocol of an exporter: one scenario, with everybody's motion, as files of another program's format."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from drivegen.core.scenario import Scenario, Trajectories


@dataclass(frozen=True)
class About:
    """What a format is: its title, and the programs that read it."""

    title: str
    read_by: str


class Exporter(Protocol):
    """Writes one format."""

    def write(self, scenario: Scenario, motion: Trajectories, folder: Path, name: str) -> None:
        """Write the scenario with its vehicles moving by `motion` (N, T) to `folder`, which is there; files are called `name`.

        Same scenario, same bytes. Raises UnusableInput for a name that cannot name a file.
        """
