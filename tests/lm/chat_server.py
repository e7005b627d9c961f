"""A stand-in for an OpenAI-compatible server, on 127.0.0.1: it plays a script of answers, one a request, and notes what it was
asked. It ends with its `with` block, and no reply of its takes longer than `HANG` seconds.
"""

import json
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

HANG = 10.0


@dataclass(frozen=True)
class Says:
    """One answer: the assistant's text, or with another status an error; `body` replaces the whole body."""

    text: str = ""
    status: int = 200
    headers: dict[str, str] = field(default_factory=dict)
    body: bytes | None = None
    hang: bool = False
    tool: bool = False


@dataclass
class ChatServer:
    """What a test sees of it."""

    url: str
    requests: list[dict[str, Any]]
    headers: list[dict[str, str]]


@contextmanager
def serving(script: Sequence[Says]) -> Iterator[ChatServer]:
    """A server that gives the answers of `script` in order and the last one for ever."""
    closing = threading.Event()
    seen: list[dict[str, Any]] = []
    headers: list[dict[str, str]] = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            asked = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            says = script[min(len(seen), len(script) - 1)]
            seen.append(asked)
            headers.append({name.lower(): value for name, value in self.headers.items()})
            if says.hang:
                closing.wait(HANG)
                return
            body = _body(says, asked) if says.body is None else says.body
            self.send_response(says.status)
            for name, value in {"Content-Type": "application/json", **says.headers}.items():
                self.send_header(name, value)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            try:
                self.wfile.write(body)
            except OSError:
                self.close_connection = True  # hung up, as is right with what is too long

        def log_message(self, *_: object) -> None:
            """Silent."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    try:
        yield ChatServer(f"http://127.0.0.1:{server.server_port}/v1", seen, headers)
    finally:
        closing.set()
        server.shutdown()
        server.server_close()
        thread.join(5)


def _body(says: Says, asked: dict[str, Any]) -> bytes:
    if says.status != 200:
        return json.dumps({"error": {"message": says.text, "type": "error", "code": "x"}}).encode()
    message: dict[str, Any] = {"role": "assistant", "content": says.text}
    if says.tool:
        name = asked["tools"][0]["function"]["name"]
        call = {"id": "1", "type": "function", "function": {"name": name, "arguments": says.text}}
        message = {"role": "assistant", "content": None, "tool_calls": [call]}
    choice = {"index": 0, "finish_reason": "stop", "message": message}
    usage = {"prompt_tokens": 120, "completion_tokens": 30, "total_tokens": 150}
    told = {"id": "x", "object": "chat.completion", "created": 1, "model": asked["model"], "choices": [choice], "usage": usage}
    return json.dumps(told).encode()
