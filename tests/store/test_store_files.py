"""Files are there whole or not at all, whatever happens while they are written."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import orjson
import pyarrow as pa
import pytest

from drivegen.core.errors import UnusableInput
from drivegen.store.files import HOST, whole, write_json, write_table, write_together

TABLE = pa.table({"x": np.arange(50_000, dtype=np.float64)})


def test_equal_content_gives_equal_bytes(tmp_path):
    for name in ("a", "b"):
        write_table(tmp_path / f"{name}.parquet", TABLE)
        write_json(tmp_path / f"{name}.json", {"b": np.float32(0.5), "a": [1, np.nan], "c": np.arange(3)})
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    assert orjson.loads((tmp_path / "a.json").read_bytes()) == {"a": [1, None], "b": 0.5, "c": [0, 1, 2]}


def test_folders_are_made_on_the_way(tmp_path):
    write_json(tmp_path / "deep" / "er" / "x.json", 1)
    assert (tmp_path / "deep" / "er" / "x.json").read_text() == "1\n"


def fail_half_way(path: Path) -> None:
    with whole(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError("half way")


def test_an_error_in_the_middle_keeps_the_old_file_and_leaves_no_other(tmp_path):
    path = tmp_path / "x.json"
    write_json(path, "old")
    with pytest.raises(RuntimeError, match="half way"):
        fail_half_way(path)
    assert path.read_text() == '"old"\n'
    assert list(tmp_path.iterdir()) == [path]


HANG_IN_THE_MIDDLE = """
import pathlib, sys, time
from drivegen.core.errors import UnusableInput
from drivegen.store.files import whole
with whole(pathlib.Path(sys.argv[1])) as part:
    part.write_bytes(b"half")
    print("half", flush=True)
    time.sleep(60)
"""


def test_a_killed_writer_leaves_nothing_that_is_taken_as_done(tmp_path):
    path = tmp_path / "shard-00000.parquet"
    with subprocess.Popen([sys.executable, "-c", HANG_IN_THE_MIDDLE, str(path)], stdout=subprocess.PIPE) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"half\n"
        os.kill(writer.pid, signal.SIGKILL)
    assert not path.exists()
    assert list(tmp_path.glob("shard-*.parquet")) == []
    [left] = tmp_path.iterdir()
    assert left.name == f".shard-00000.parquet.{HOST}.{writer.pid}.part"
    others = [
        tmp_path / f".shard-00000.parquet.{HOST}.{os.getppid()}.part",
        tmp_path / f".shard-00001.parquet.{HOST}.4194305.part",
        tmp_path / ".shard-00000.parquet.elsewhere.4194305.part",  # of another machine that shares the folder
    ]
    for other in others:
        other.write_bytes(b"")
    left.with_name(f"{left.name}.wal").write_bytes(b"")
    write_table(path, TABLE)  # what a dead writer left goes, what others are at stays
    assert sorted(tmp_path.iterdir()) == sorted([*others, path])


WRITE_TOO_MUCH = """
import pathlib, resource, signal, sys
import numpy as np, pyarrow as pa
from drivegen.core.errors import UnusableInput
from drivegen.store.files import write_table
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))  # stands in for a full disk
try:
    write_table(pathlib.Path(sys.argv[1]), pa.table({"x": np.random.default_rng(0).random(50_000)}))
except OSError:
    sys.exit(7)
"""


def test_a_full_disk_is_an_error_and_keeps_the_old_file(tmp_path):
    path = tmp_path / "x.parquet"
    write_table(path, pa.table({"x": [1]}))
    before = path.read_bytes()
    done = subprocess.run([sys.executable, "-c", WRITE_TOO_MUCH, str(path)], check=False)
    assert done.returncode == 7
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_readers_never_see_a_file_in_the_making(tmp_path):
    path = Path(tmp_path / "x.json")
    with whole(path) as temporary:
        temporary.write_text("1")
        assert not path.exists()
    assert path.read_text() == "1"


def test_what_is_no_plain_file_is_never_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UnusableInput, match="no plain file"):
        write_json(tmp_path / "pipe", 1)
    assert (tmp_path / "pipe").is_fifo()
    (tmp_path / "link").symlink_to("mine.json")
    for mine in (None, "mine"):  # a link that leads nowhere, and one to a plain file
        with pytest.raises(UnusableInput, match="link is there and no plain file"):
            write_json(tmp_path / "link", mine)
        (tmp_path / "mine.json").write_text("mine")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "mine.json").read_text() == "mine"


def test_a_path_through_a_file_is_told_as_such(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(UnusableInput, match="file is there and no folder"):
        write_json(tmp_path / "file" / "x.json", 1)
    assert (tmp_path / "file").read_text() == "mine"


def test_what_the_disk_says_names_the_file_that_was_asked_for(tmp_path):
    def full() -> None:
        with whole(tmp_path / "x.json"):
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OSError, match="No space left") as fault:
        full()
    assert fault.value.filename == str(tmp_path / "x.json")
    with pytest.raises(OSError, match="too long") as fault, whole(tmp_path / ("x" * 300)) as temporary:
        temporary.write_bytes(b"")
    assert fault.value.filename == str(tmp_path / ("x" * 300))


def test_of_files_that_belong_together_all_are_replaced_or_none(tmp_path):
    write_together(tmp_path, {"a": b"1", "b": b"1"})
    (tmp_path / "c").mkdir()
    with pytest.raises(UnusableInput, match="no plain file"):
        write_together(tmp_path, {"a": b"2", "b": b"2", "c": b"2"})
    assert {name: (tmp_path / name).read_bytes() for name in "ab"} == {"a": b"1", "b": b"1"}
    write_together(tmp_path, {"a": b"3", "b": b"3"})
    assert (tmp_path / "b").read_bytes() == b"3"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b", "c"]
