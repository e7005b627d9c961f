"""A Prefect server of our own for the time of one flow, on 127.0.0.1 and a free port.

Without it Prefect starts a hidden one inside the flow's process, which prints hundreds of lines of tracebacks when it
ends. Its database and log stay in .drivegen/prefect. It ends with the flow, also where that is killed (`attended.py`). Where
PREFECT_API_URL is set, that server is used instead.
"""

import fcntl
import os
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from flows import attended

HOME = Path(".drivegen/prefect")
_READY_WITHIN = 90.0
_STOP_WITHIN = 10.0

QUIET = {"DO_NOT_TRACK": "1", "PREFECT_SERVER_ANALYTICS_ENABLED": "false", "PREFECT_LOGGING_SERVER_LEVEL": "ERROR"}
"""Settings for the server and for flows: nothing leaves the machine."""


def settle(home: Path = HOME) -> None:
    """Put our settings into the environment; to be called before Prefect is imported, which reads them once."""
    for name, value in {**QUIET, "PREFECT_HOME": str(home.resolve())}.items():
        os.environ.setdefault(name, value)


@contextmanager
def local_server(home: Path = HOME, meanwhile: Callable[[], object] = lambda: None) -> Iterator[str]:
    """The URL of a running server's API; `meanwhile` (slow imports) is called while it starts.

    Raises RuntimeError, naming the log, if it does not come up.
    """
    settle(home)
    if url := os.environ.get("PREFECT_API_URL"):
        meanwhile()
        yield url
        return
    others = os.environ.get("no_proxy") or os.environ.get("NO_PROXY")
    os.environ["no_proxy"] = f"{others},127.0.0.1" if others else "127.0.0.1"  # a proxy does not reach our own server
    home.mkdir(parents=True, exist_ok=True)
    with (home / "server.log").open("a") as log:  # another flow's server may be writing to it, too
        fcntl.flock(log, fcntl.LOCK_EX)  # servers of flows begun at once start in turn: of two that make one database one fails
        port = _free_port()
        url = f"http://127.0.0.1:{port}/api"
        command = [sys.executable, "-m", "prefect", "server", "start", "--host", "127.0.0.1", "--port", str(port), "--no-ui"]
        # In its own session Ctrl-C reaches the flow alone, which still needs the server to write down that it was stopped.
        server = attended.start(command, stdout=log, stderr=subprocess.STDOUT)
        try:
            os.environ["PREFECT_API_URL"] = url
            meanwhile()
            _await(url, server, home / "server.log")
            fcntl.flock(log, fcntl.LOCK_UN)
            yield url
        finally:
            drain()
            os.environ.pop("PREFECT_API_URL", None)
            attended.end(server)
            server.wait()


def drain() -> None:
    """Send what Prefect still holds back (log lines, events): without its server it would retry for over a minute."""
    from prefect.events.worker import EventsWorker
    from prefect.logging.handlers import APILogWorker

    APILogWorker.drain_all(timeout=_STOP_WITHIN)
    EventsWorker.drain_all(timeout=_STOP_WITHIN)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _await(url: str, server: "subprocess.Popen[bytes]", log: Path) -> None:
    deadline = time.monotonic() + _READY_WITHIN
    while time.monotonic() < deadline and server.poll() is None:
        try:
            with urllib.request.urlopen(f"{url}/health", timeout=2) as answer:  # noqa: S310 - our own loopback address
                if answer.status == 200:
                    return
        except (urllib.error.URLError, ConnectionError, TimeoutError):
            time.sleep(0.1)
    raise RuntimeError(f"the local Prefect server did not start: see {log}; `drivegen doctor` checks its versions")
