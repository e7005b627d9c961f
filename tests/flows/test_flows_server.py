"""What surrounds a flow's own server, without Prefect behind it."""

import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import TextIO
from unittest.mock import Mock

import pytest

from flows import attended, server


class Well(BaseHTTPRequestHandler):
    """Says that all is well."""

    def do_GET(self):
        self.send_response(200)
        self.end_headers()


def start(command: list[str], **_: object) -> Mock:
    """In place of Prefect's server one that answers at once."""
    answering = HTTPServer(("127.0.0.1", int(command[command.index("--port") + 1])), Well)
    threading.Thread(target=answering.serve_forever, daemon=True).start()
    return Mock(stdin=None, poll=lambda: None, wait=lambda: (answering.shutdown(), answering.server_close()))


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """No Prefect, and an environment that is as it was afterwards."""
    monkeypatch.setattr(attended, "start", start)
    monkeypatch.setattr(server, "drain", lambda: None)
    monkeypatch.setattr(server, "_READY_WITHIN", 10.0)
    for name in ("PREFECT_API_URL", "PREFECT_HOME", "no_proxy"):
        monkeypatch.setenv(name, "")


@pytest.mark.parametrize(("others", "no_proxy"), [("", "127.0.0.1"), ("example.org", "example.org,127.0.0.1")])
def test_a_proxy_is_not_asked_for_our_own_server(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, others: str, no_proxy: str
) -> None:
    monkeypatch.setenv("NO_PROXY", others)
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")  # where nobody answers
    with server.local_server(tmp_path) as url:
        assert url.startswith("http://127.0.0.1:")
        assert server.os.environ["no_proxy"] == no_proxy


def test_nothing_leaves_the_machine_unless_somebody_wants_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in server.QUIET:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PREFECT_LOGGING_SERVER_LEVEL", "INFO")
    server.settle(tmp_path)
    wanted = ("DO_NOT_TRACK", "PREFECT_SERVER_ANALYTICS_ENABLED", "PREFECT_LOGGING_SERVER_LEVEL")
    assert [server.os.environ[name] for name in wanted] == ["1", "false", "INFO"]


def test_the_second_of_two_flows_begun_at_once_starts_its_server_when_the_first_one_s_is_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[list[str]] = []

    def noted(command: list[str], stdout: TextIO, **_: object) -> Mock:
        begun.append(command)
        stdout.write(f"server {len(begun)}\n")
        stdout.flush()
        return start(command)

    def flow() -> None:
        with server.local_server(tmp_path):
            pass

    def meanwhile() -> None:
        server.os.environ.pop("PREFECT_API_URL")  # the second flow has an environment of its own
        second.start()
        second.join(0.5)
        assert len(begun) == 1

    monkeypatch.setattr(attended, "start", noted)
    second = threading.Thread(target=flow)
    with server.local_server(tmp_path, meanwhile):
        second.join(10.0)
    assert (tmp_path / "server.log").read_text() == "server 1\nserver 2\n"
    assert [command[command.index("--host") + 1] for command in begun] == ["127.0.0.1"] * 2
