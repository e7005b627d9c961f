"""Loops that Numba has compiled are those of the code as it is."""

import contextlib
import hashlib
import os
from pathlib import Path

PACKAGE = Path(__file__).parent.parent


def forget_compiled() -> None:
    """Remove what Numba compiled of other code of this package, if anything may have changed there.

    Numba notices edits of a loop's own file, none of what that calls or reads, and then goes on with the old code. A folder that
    cannot be written has nothing that was compiled here.
    """
    files = sorted((str(file.relative_to(PACKAGE)), file.stat()) for file in PACKAGE.rglob("*.py"))
    code = hashlib.sha256(repr([(name, stat.st_mtime_ns, stat.st_size) for name, stat in files]).encode()).hexdigest()
    compiled = Path(os.environ.get("NUMBA_CACHE_DIR") or PACKAGE)
    note = compiled / "__pycache__" / "compiled_of"
    if note.exists() and note.read_text() == code:
        return
    with contextlib.suppress(OSError):
        for index in compiled.rglob("*.nbi"):
            index.unlink(missing_ok=True)
        note.parent.mkdir(parents=True, exist_ok=True)
        note.write_text(code)
