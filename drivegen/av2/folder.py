"""One scenario folder in the official layout, read whole: `scenario_<id>.parquet`, `log_map_archive_<id>.json`.

Source: argoverse/av2-api, `datasets/motion_forecasting/scenario_serialization.py`.
"""

from pathlib import Path

import pyarrow as pa

from drivegen.av2.maps import read_map
from drivegen.av2.schema import READ, REPEATED
from drivegen.av2.signals import read_signals
from drivegen.av2.tracks import read_log
from drivegen.core.errors import UnusableInput
from drivegen.core.recorded_log import RecordedLog
from drivegen.core.safe_parquet import expect_flat, open_parquet
from drivegen.store.files import content_of


def scenario_files(folder: Path) -> tuple[Path, ...]:
    """The files of one scenario folder: tracks, map and, if there, signals.

    Raises UnusableInput, reason `no-such-scenario`, where there is not exactly one of each of the first two.
    """
    tracks, maps = sorted(folder.glob("scenario_*.parquet")), sorted(folder.glob("log_map_archive_*.json"))
    for files, pattern in ((tracks, "scenario_<id>.parquet"), (maps, "log_map_archive_<id>.json")):
        if len(files) != 1:
            raise UnusableInput(
                f"{folder} holds {len(files)} files {pattern}; an Argoverse 2 scenario has one", reason="no-such-scenario"
            )
    return tracks[0], maps[0], *sorted(folder.glob("signals_*.json"))[:1]


def read_folder(folder: Path, source: str) -> RecordedLog:
    """The recording in `folder`, tracks in the map's local frame.

    Raises UnusableInput with a countable reason (see `read_map`, `read_table`, `read_log`), naming the file.
    """
    tracks, archive, *signals = scenario_files(folder)
    road_map = read_map(content_of(archive), str(archive))
    states = read_signals(content_of(signals[0]), road_map, str(signals[0])) if signals else None
    return read_log(read_table(tracks), road_map, source, str(tracks), states)


def read_table(path: Path) -> pa.Table:
    """The columns of a tracks file that `read_log` takes, words as dictionaries.

    Raises UnusableInput, reason `truncated`, for a file that is empty, cut short or no Parquet, `missing-columns` or `too-large`.
    """
    try:
        with open_parquet(pa.BufferReader(path.read_bytes()), path, read_dictionary=REPEATED) as file:
            expect_flat(file.schema_arrow, READ, path)
            table = file.read(columns=READ, use_threads=False)
            for name, column in zip(table.column_names, table.columns, strict=True):
                if name in REPEATED:
                    column.validate(full=True)  # UTF-8, indices in range
            return table
    except KeyError as error:  # pyarrow's for a dictionary column that is not there
        name = error.args[0].decode() if isinstance(error.args[0], bytes) else error.args[0]
        raise UnusableInput(f"{path} lacks the column {name}", reason="missing-columns") from None
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        what = str(error).splitlines()[0]
        raise UnusableInput(f"{path} is no whole Parquet file ({what}): copy it again", reason="truncated") from None
