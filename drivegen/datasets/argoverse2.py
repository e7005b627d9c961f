"""Argoverse 2 Motion Forecasting: `<root>/{train,val,test}/<uuid>/`, one official folder a scene.

Source: Wilson et al., "Argoverse 2", NeurIPS 2021 Datasets; layout as argoverse/av2-api downloads it. 11 s at 10 Hz,
no box sizes, no signals; in the test split the last 6 s are withheld.
"""

import os
from pathlib import Path

from drivegen.av2.folder import read_folder, scenario_files
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.datasets.base import expect_splits


class Plugin:
    """The data set below `root`; see `base.Dataset`."""

    description = "Argoverse 2 Motion Forecasting"

    def __init__(self, root: Path) -> None:
        expect_splits(root, "Argoverse 2 Motion Forecasting", "one folder a scene")
        self.root = root

    def scenes(self, split: str) -> list[str]:
        """Folder names, sorted."""
        folder = self.root / split
        if not folder.is_dir():
            return []
        with os.scandir(folder) as entries:  # 200 000 folders: no Path object each
            return sorted(entry.name for entry in entries if entry.is_dir() and not entry.name.startswith("."))

    def read(self, split: str, scene: str) -> RecordedLog:
        """One scene; raises UnusableInput with a countable reason."""
        folder = self.root / split / scene
        log = read_folder(folder, self.description)
        if log.scenario_id != scene:
            raise UnusableInput(f"{folder} holds the scenario {log.scenario_id[:50]!r}: name the folder so", reason="bad-id")
        return log

    def files(self, split: str, scene: str) -> tuple[Path, ...]:
        """Tracks, map and, if there, signals."""
        return scenario_files(self.root / split / scene)
