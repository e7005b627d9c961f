"""CommonRoad: `<root>/{train,val,test}/*.xml`, recordings of versions 2018b and 2020a; read by `drivegen/commonroad/`.

Source: Althoff, Koschi, Manzinger, "CommonRoad: Composable benchmarks for motion planning on roads", IEEE IV 2017. Its
recordings of human driving stem from NGSIM (US Department of Transportation, public data) with maps from OpenStreetMap
(ODbL). Boxes are measured, but flat. There is no recording car (the planning problem's has neither box nor trajectory)
and no focal track, but one recording shows many cars: it gives several scenes, `<file>:<number>`, one for each target.
Split by file, so by recording.
"""

import os
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from drivegen.commonroad.recording import read_recording
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.signals import Signals
from drivegen.datasets._targets import spread_targets
from drivegen.datasets.base import expect_splits, id_of
from drivegen.store.files import content_of

WINDOW = 110
"""Steps of a scene at most, as in Argoverse 2; a longer recording is several windows, one after the other."""

SHORTEST = 71
"""What remains of a longer recording is a window where it has so many steps, the 7 s that are taken of every recording."""


class Plugin:
    """The data set below `root`; see `base.Dataset`."""

    description = "CommonRoad"

    def __init__(self, root: Path) -> None:
        expect_splits(root, "CommonRoad recordings", "XML files")
        self.root = root
        self._recording = lru_cache(maxsize=1)(_read)  # scenes of one file are read one after the other

    def scenes(self, split: str) -> list[str]:
        """`<file>:<number>`, sorted; a file that cannot be read is one scene, which `read` rejects."""
        files = (self.root / split).glob("[!.]*.xml")
        return sorted(f"{path.stem}:{n:03d}" for path in files for n in range(self._count(path)))

    def read(self, split: str, scene: str) -> RecordedLog:
        """One window with one target as the focal track; raises UnusableInput with a countable reason."""
        name, _, number = scene.rpartition(":")
        path = self.root / split / f"{name}.xml"
        if not name or Path(name).name != name or not number.isdecimal() or not os.path.lexists(path):
            raise UnusableInput(
                f"{path.parent} holds no scene {scene!r}: they are called <file>:<number>", reason="no-such-scenario"
            )
        recording, targets = self._recording(path)
        if not targets:
            raise UnusableInput(f"{path} has no vehicle that is there at its first step", reason="no-target")
        if int(number) >= len(targets):
            raise UnusableInput(f"{path} gives {len(targets)} scenes: there is no {scene!r}", reason="no-such-scenario")
        return _cut(recording, scene, *targets[int(number)])

    def files(self, split: str, scene: str) -> tuple[Path, ...]:
        """The recording."""
        path = self.root / split / f"{scene.rpartition(':')[0]}.xml"
        return (path,) if path.is_file() else ()

    def _count(self, path: Path) -> int:
        try:
            return max(1, len(self._recording(path)[1]))
        except UnusableInput:
            return 1


def _read(path: Path) -> tuple[RecordedLog, list[tuple[int, int]]]:
    """A recording, and first step and target of each of its scenes."""
    log = read_recording(content_of(path), str(path), Plugin.description)
    scenes = []
    for first in range(0, max(1, log.motion.steps - SHORTEST + 1), WINDOW):
        scenes += [(first, target) for target in spread_targets(log.kind, log.motion.between(first, first + WINDOW))]
    return log, scenes


def _cut(log: RecordedLog, scene: str, first: int, target: int) -> RecordedLog:
    motion = log.motion.between(first, first + WINDOW)
    present = np.asarray(motion.valid.any(-1))
    return replace(
        log,
        scenario_id=id_of(scene),
        track_id=log.track_id[present],
        kind=log.kind[present],
        size=log.size[present],
        motion=motion[present],
        focal=int(np.count_nonzero(present[:target])),
        signals=Signals(log.signals.lane, log.signals.state[:, first : first + WINDOW]),
    )
