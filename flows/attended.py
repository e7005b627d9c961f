"""Commands that end when we do, however we end: a kill -9 leaves no server and no stage behind.

Each runs in a session of its own under an attendant, which is this file run as a program. The attendant's standard input is a
pipe whose other end we hold; when that closes, because we closed it or are gone, the attendant ends the whole session.
"""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""What asks us to stop."""

GRACE = 10.0
"""Seconds that a session has to end itself before it is killed."""

_WORK: set["subprocess.Popen[Any]"] = set()
_STOPPED = threading.Event()


def start(command: list[str], **options: Any) -> "subprocess.Popen[Any]":
    """`command` under its attendant; `options` as for Popen. `end` ends it."""
    attendant = [sys.executable, "-I", __file__, *command]
    return subprocess.Popen(attendant, stdin=subprocess.PIPE, start_new_session=True, **options)


def end(process: "subprocess.Popen[Any]") -> None:
    """Have the attendant end its session; who wants to know when `wait`s."""
    if process.stdin is not None:
        process.stdin.close()


@contextmanager
def work(command: list[str], **options: Any) -> Iterator["subprocess.Popen[Any]"]:
    """As `start`, for what is to end as soon as we are asked to stop. Raises InterruptedError where we have been already."""
    with start(command, **options) as process:  # which at its end closes our end of the pipe, and waits
        _WORK.add(process)
        try:
            if _STOPPED.is_set():
                raise InterruptedError("the flow was stopped")
            yield process
        finally:
            _WORK.discard(process)


@contextmanager
def stopping_work() -> Iterator[None]:
    """While the block runs, a signal of `STOPS` ends all `work` at once, whoever else handles it and however slowly."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=_end_work, args=(reading,), daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writing)


def _end_work(reading: int) -> None:
    while number := os.read(reading, 1):
        if number[0] in STOPS:
            _STOPPED.set()
            for process in list(_WORK):
                end(process)


def attend(command: list[str]) -> int:
    """Run `command` until it ends, or our standard input does; its exit code. What it leaves of the session ends, too."""
    for number in STOPS:
        signal.signal(number, lambda *_: None)  # not SIG_IGN, which the command would inherit
    try:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL)
    except OSError as error:
        sys.stderr.write(f"{command[0]}: {error.strerror}\n")
        return 127
    threading.Thread(target=_end_session, daemon=True).start()
    code = process.wait()
    os.killpg(0, signal.SIGTERM)  # workers of a stage that was killed would wait for it for ever
    return code if code >= 0 else 128 - code


def _end_session() -> None:
    os.read(0, 1)  # nothing is ever written: this is the end of the pipe
    os.killpg(0, signal.SIGINT)
    threading.Event().wait(GRACE)
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    sys.exit(attend(sys.argv[1:]))
