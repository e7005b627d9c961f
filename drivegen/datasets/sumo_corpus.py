"""The embedded corpus: simulated logs in Argoverse 2's layout, many scenarios to a file.

    <root>/<split>/tracks-<part>.parquet   official columns and length, width, height; one row group a scenario
    <root>/<split>/maps-<part>.parquet     scenario_id, city, log_map_archive, signals (JSON of av2.signals), per_hour

Row group k of the tracks belongs to row k of the maps. Everything is named "SUMO corpus (simulated)".
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from drivegen.av2.maps import read_map, write_map
from drivegen.av2.schema import COLUMNS, READ, REPEATED
from drivegen.av2.signals import read_signals, write_signals
from drivegen.av2.tracks import read_log, track_table
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.safe_parquet import open_parquet
from drivegen.core.scenario import Scenario
from drivegen.core.seal import BLANK, expect_seal, seal_file
from drivegen.store.files import whole

_MAPS = pa.schema(
    [
        ("scenario_id", pa.string()),
        ("city", pa.string()),
        ("log_map_archive", pa.binary()),
        ("signals", pa.binary()),
        ("per_hour", pa.float64()),
    ]
)

_AGAIN = "run the stage `corpus` again"


class Plugin:
    """Reads the corpus below a folder; keeps one shard open, so scenes are best read in order."""

    description = "SUMO corpus (simulated)"

    def __init__(self, root: Path) -> None:
        if not root.is_dir():
            raise UnusableInput(f"{root} is not there: run the stage `corpus`, or name the folder that holds its splits")
        self._root = root
        self._index: dict[str, dict[str, tuple[Path, int]]] = {}
        self._open: tuple[Path, pq.ParquetFile, pa.Table] | None = None

    def scenes(self, split: str) -> list[str]:
        """Scenario ids of a split, sorted; empty if the split is absent."""
        return sorted(self._scenes(split))

    def read(self, split: str, scene: str) -> RecordedLog:
        """One recording with its map and signals. Raises UnusableInput where the files cannot be used."""
        row_of_shard = self._scenes(split).get(scene)
        if row_of_shard is None:
            raise UnusableInput(f"{self._root / split} holds no scenario {scene!r}", reason="no-rows")
        path, row = row_of_shard
        tracks, maps = self._shard(path)
        place = f"{path} [{scene}]"
        try:
            table = tracks.read_row_group(row, columns=READ, use_threads=False)
            record = maps.slice(row, 1).to_pylist()[0]
        except (pa.ArrowException, OSError, IndexError) as error:
            raise UnusableInput(f"{place} cannot be read: {error}", reason="truncated") from None
        road_map = read_map(record["log_map_archive"], place)
        log = read_log(table, road_map, self.description, place, read_signals(record["signals"], road_map, place))
        if log.scenario_id != scene:
            raise UnusableInput(f"{place} holds the tracks of another scenario: {_AGAIN}", reason="damaged")
        return replace(log, per_hour=record["per_hour"])

    def files(self, split: str, scene: str) -> tuple[Path, ...]:
        """The scene's shard: tracks and maps."""
        place = self._scenes(split).get(scene)
        return () if place is None else (place[0], _maps_of(place[0]))

    def _scenes(self, split: str) -> dict[str, tuple[Path, int]]:
        if split not in self._index:
            index: dict[str, tuple[Path, int]] = {}
            for maps in sorted((self._root / split).glob("maps-*.parquet")):
                tracks = maps.with_name(maps.name.replace("maps-", "tracks-", 1))
                index.update({name: (tracks, row) for row, name in enumerate(_ids(maps))})
            self._index[split] = index
        return self._index[split]

    def _shard(self, path: Path) -> tuple[pq.ParquetFile, pa.Table]:
        if self._open is None or self._open[0] != path:
            maps = _maps_of(path)
            try:
                self._open = (path, _opened(path, by_groups=True, read_dictionary=REPEATED), _table(maps))
            except (pa.ArrowException, OSError, ValueError) as error:
                raise UnusableInput(f"{path} or {maps.name} cannot be read ({error}): {_AGAIN}", reason="truncated") from None
        return self._open[1], self._open[2]


def _opened(path: Path, **options: Any) -> pq.ParquetFile:
    """The file, proved to be what was written. Raises as `open_parquet` and `expect_seal`."""
    raw = path.read_bytes()
    file = open_parquet(pa.BufferReader(raw), path, **options)
    expect_seal(raw, path, _AGAIN)
    return file


def _table(maps: Path) -> pa.Table:
    return _opened(maps).read(use_threads=False).cast(_MAPS)


def _ids(maps: Path) -> list[str]:
    try:
        return [str(name) for name in _opened(maps).read(["scenario_id"], use_threads=False)["scenario_id"].to_pylist()]
    except (pa.ArrowException, OSError, KeyError) as error:
        raise UnusableInput(f"{maps} cannot be read ({error}): {_AGAIN}", reason="truncated") from None


def _maps_of(tracks: Path) -> Path:
    return tracks.with_name(tracks.name.replace("tracks-", "maps-", 1))


def write_part(folder: Path, part: str, scenarios: Sequence[Scenario]) -> None:
    """Write scenarios with a log as `tracks-<part>.parquet` and `maps-<part>.parquet`; same scenarios, same bytes.

    The maps are written last: without them a part does not exist, so old ones are removed first.
    """
    maps = folder / f"maps-{part}.parquet"
    with _sealed(folder / f"tracks-{part}.parquet", COLUMNS) as write:
        maps.unlink(missing_ok=True)
        for scenario in scenarios:
            if scenario.log is None:
                raise UnusableInput(f"scenario {scenario.scenario_id} has no log to write", reason="no-rows")
            write(track_table(scenario, scenario.log, scenario.scenario_id))
    rows = [
        {
            "scenario_id": scenario.scenario_id,
            "city": scenario.city,
            "log_map_archive": write_map(scenario.map),
            "signals": write_signals(scenario.signals, scenario.map),
            "per_hour": scenario.per_hour,
        }
        for scenario in scenarios
    ]
    with _sealed(maps, _MAPS) as write:
        write(pa.Table.from_pylist(rows, _MAPS))


@contextmanager
def _sealed(path: Path, schema: pa.Schema) -> Iterator[Callable[[pa.Table], None]]:
    """What writes tables, a row group each, into a file that appears whole and with a checksum in it."""
    with whole(path) as temporary:
        with pq.ParquetWriter(temporary, schema, compression="zstd", compression_level=3) as writer:
            yield writer.write_table
            writer.add_key_value_metadata({"drivegen.checksum": BLANK})
        seal_file(temporary)
