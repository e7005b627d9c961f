"""Loops that Numba has compiled are those of the code as it is.

Numba notices edits of a loop's own file, none of what that calls or reads, and then goes on with the old code.
"""

import hashlib
import os
import re
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

PACKAGE = Path(__file__).parent.parent
_OURS = re.compile(r"drivegen-[0-9a-f]{16}")


def keep_compiled() -> None:
    """Have Numba use what it compiled of this very code and nothing else of this package; nobody else's is touched.

    Beside the code, where that can be written, what is of other code is removed. In a folder that other projects may share, such
    as NUMBA_CACHE_DIR, each state of the code has a folder of its own; earlier ones are left, for a run may be using them.
    """
    files = sorted((str(file.relative_to(PACKAGE)), file.stat()) for file in PACKAGE.rglob("*.py"))
    code = hashlib.sha256(repr([(name, stat.st_mtime_ns, stat.st_size) for name, stat in files]).encode()).hexdigest()
    with suppress(OSError):  # nowhere to keep it: Numba says so
        if (shared := _shared()) is None:
            _forget(code)
            return
        os.environ["NUMBA_CACHE_DIR"] = str(shared / f"drivegen-{code[:16]}")
        if "numba" in sys.modules:  # which has read the variable already
            sys.modules["numba"].config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]


def _shared() -> Path | None:
    """The named folder for compiled code; else None, beside the code; else at home, else among this user's temporary files."""
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(named).parent if _OURS.fullmatch(Path(named).name) else Path(named)  # a parent process has been here
    if os.access(PACKAGE, os.W_OK):
        return None
    with suppress(OSError, RuntimeError):  # nobody may have no home at all
        home = Path(os.environ.get("XDG_CACHE_HOME", "~/.cache"), "numba").expanduser()
        home.mkdir(parents=True, exist_ok=True)
        if os.access(home, os.W_OK):
            return home
    ours = Path(tempfile.gettempdir(), f"drivegen-{os.getuid()}")
    ours.mkdir(mode=0o700, exist_ok=True)
    if ours.lstat().st_uid != os.getuid():  # somebody else's, and what is compiled there would be run
        return Path(tempfile.mkdtemp(prefix="drivegen-"))
    return ours


def _forget(code: str) -> None:
    """Remove what is compiled beside the code, unless it is of this `code`."""
    note = PACKAGE / "__pycache__" / "compiled_of"
    if note.exists() and note.read_text() == code:
        return
    for index in PACKAGE.rglob("*.nbi"):
        index.unlink(missing_ok=True)
    note.parent.mkdir(parents=True, exist_ok=True)
    note.write_text(code)
