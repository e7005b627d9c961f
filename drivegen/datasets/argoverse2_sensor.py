"""Argoverse 2 Sensor: `<root>/{train,val,test}/<log>/` with annotated boxes of true size, ego poses and a vector map.

Source: Wilson et al., "Argoverse 2", NeurIPS 2021 Datasets; one log is read by `av2/sensor.py`. Logs last 15 s; scenes
are windows of 11 s, begun every 2 s (so windows of one log overlap), named `<log>:<window>`; the first one begins when
velocities can be fitted to what came before. There is no focal track.
"""

from functools import lru_cache
from pathlib import Path

import numpy as np

from drivegen.av2.schema import EGO_TRACK
from drivegen.av2.sensor import FITTED, SensorLog, count_steps, log_files, read_sensor_log
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import NO_TRACK, RecordedLog
from drivegen.core.signals import Signals
from drivegen.datasets.base import expect_splits, id_of

WINDOW = 110
"""Steps of a scene, as in Motion Forecasting; a shorter log is one shorter scene."""

STRIDE = 20
"""Steps from one window's beginning to the next one's."""


class Plugin:
    """The data set below `root`; see `base.Dataset`."""

    description = "Argoverse 2 Sensor"

    def __init__(self, root: Path) -> None:
        expect_splits(root, "Argoverse 2 Sensor logs", "one folder a log")
        self.root = root
        self._log = lru_cache(maxsize=1)(read_sensor_log)  # windows of one log are read one after the other

    def scenes(self, split: str) -> list[str]:
        """`<log>:<window>`, sorted; a log whose annotations cannot be read is one scene, which `read` rejects."""
        folder = self.root / split
        logs = sorted(path for path in folder.glob("[!.]*") if path.is_dir())
        return [f"{log.name}:{window}" for log in logs for window in range(_windows(log))]

    def read(self, split: str, scene: str) -> RecordedLog:
        """One window; raises UnusableInput with a countable reason."""
        name, _, window = scene.rpartition(":")
        if not name or not window.isdecimal():
            raise UnusableInput(
                f"{scene!r} is no scene of {self.root}: they are called <log>:<window>", reason="no-such-scenario"
            )
        log = self._log(self.root / split / name)
        first = FITTED - 1 + int(window) * STRIDE
        if first >= log.motion.steps:
            raise UnusableInput(f"{scene}: the log has {log.motion.steps} frames only", reason="no-such-scenario")
        return _cut(log, scene, first, first + WINDOW)

    def files(self, split: str, scene: str) -> tuple[Path, ...]:
        """Annotations, poses and map of the log."""
        return log_files(self.root / split / scene.rpartition(":")[0])


def read_whole_log(folder: Path) -> RecordedLog:
    """All frames of the log in `folder`; raises UnusableInput with a countable reason."""
    log = read_sensor_log(folder)
    return _cut(log, folder.name, 0, log.motion.steps)


def _windows(log: Path) -> int:
    try:
        return 1 + max(0, count_steps(log) - FITTED + 1 - WINDOW) // STRIDE
    except UnusableInput:
        return 1


def _cut(log: SensorLog, scene: str, first: int, end: int) -> RecordedLog:
    motion = log.motion.between(first, end)
    present = motion.valid.any(-1)
    ego = np.flatnonzero(log.track_id[present] == EGO_TRACK)
    return RecordedLog(
        scenario_id=id_of(scene),
        source=Plugin.description,
        city=log.city,
        map=log.road_map,
        track_id=log.track_id[present],
        kind=log.kind[present],
        size=log.size[present],
        motion=motion[present],
        focal=NO_TRACK,
        ego=int(ego[0]) if len(ego) else NO_TRACK,
        signals=Signals.none(motion.steps),
        skipped=log.skipped,
    )
