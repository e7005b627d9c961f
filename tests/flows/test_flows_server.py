"""What surrounds a flow's own server, without Prefect behind it."""

import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
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


@pytest.mark.parametrize(("others", "no_proxy"), [("", "127.0.0.1"), ("example.org", "example.org,127.0.0.1")])
def test_a_proxy_is_not_asked_for_our_own_server(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, others: str, no_proxy: str
) -> None:
    monkeypatch.setattr(attended, "start", start)
    monkeypatch.setattr(server, "drain", lambda: None)
    monkeypatch.setattr(server, "_READY_WITHIN", 10.0)
    for name in ("PREFECT_API_URL", "PREFECT_HOME", "no_proxy"):
        monkeypatch.setenv(name, "")  # so that they are as they were afterwards
    monkeypatch.setenv("NO_PROXY", others)
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")  # where nobody answers
    with server.local_server(tmp_path) as url:
        assert url.startswith("http://127.0.0.1:")
        assert server.os.environ["no_proxy"] == no_proxy
