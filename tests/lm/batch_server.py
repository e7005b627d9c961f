"""A stand-in for the vendors' batch endpoints, on 127.0.0.1: jobs end at the second look, answers come from a script."""

import json
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

_TIMES = {"created_at": 1, "endpoint": "/v1/responses", "completion_window": "24h", "input_file_id": "in"}


class BatchServer:
    """What a test sees of it: `jobs`, a list of requests each, in the vendor's own form."""

    def __init__(self, answers: Sequence[str | None]) -> None:
        self.url, self.jobs, self.looks = "", [], {}
        self._answers, self._uploaded = list(answers), b""

    def openai(self, method: str, path: str, body: bytes) -> tuple[str, bytes]:
        """OpenAI's protocol: a file of requests, a job over it, a file of results."""
        if method == "POST" and path.endswith("/files"):
            self._uploaded = body
            return "application/json", json.dumps({"id": "in", "object": "file", "bytes": 1, "created_at": 1, "filename": "x",
                                                   "purpose": "batch", "status": "processed"}).encode()  # fmt: skip
        if method == "POST" and path.endswith("/batches"):
            lines = [line for line in self._uploaded.split(b"\n") if line.startswith(b"{")]
            self.jobs.append([json.loads(line) for line in lines])
            return self._job(len(self.jobs) - 1)
        if "/batches/" in path:
            return self._job(int(path.rsplit("b", 1)[1]))
        requests = self.jobs[int(path.split("/out")[1].split("/")[0])]
        return "application/jsonl", b"\n".join(self._openai_line(request) for request in requests) + b"\n"

    def _job(self, number: int) -> tuple[str, bytes]:
        self.looks[number] = self.looks.get(number, -1) + 1
        done = self.looks[number] > 0
        counts = {"total": 1, "completed": int(done), "failed": 0}
        told = {"id": f"b{number}", "object": "batch", "status": "completed" if done else "in_progress", **_TIMES}
        return "application/json", json.dumps(
            {**told, "request_counts": counts, "output_file_id": f"out{number}" if done else None}
        ).encode()

    def _openai_line(self, request: dict[str, Any]) -> bytes:
        text = self._answers.pop(0)
        told: dict[str, Any] = {"id": "r", "custom_id": request["custom_id"], "error": None}
        if text is None:
            refusal = {"error": {"message": "no", "type": "invalid_request_error", "code": "x"}}
            return json.dumps({**told, "response": {"status_code": 400, "request_id": "q", "body": refusal}}).encode()
        content = [{"type": "output_text", "text": text, "annotations": []}]
        message = {"id": "m", "type": "message", "role": "assistant", "status": "completed", "content": content}
        details = {"input_tokens_details": {"cached_tokens": 0}, "output_tokens_details": {"reasoning_tokens": 0}}
        usage = {"input_tokens": 120, "output_tokens": 30, "total_tokens": 150, **details}
        body = {"id": "x", "object": "response", "created_at": 1, "model": "gpt-4o", "status": "completed", "output": [message]}
        body |= {"usage": usage, "parallel_tool_calls": True, "tool_choice": "auto", "tools": []}
        return json.dumps({**told, "response": {"status_code": 200, "request_id": "q", "body": body}}).encode()

    def anthropic(self, method: str, path: str, body: bytes) -> tuple[str, bytes]:
        """Anthropic's protocol: a job made of requests, and a list of results at an address that the ended job names."""
        if method == "POST":
            self.jobs.append(json.loads(body)["requests"])
            return self._anthropic_job(len(self.jobs) - 1)
        number = int(path.rsplit("/b", 1)[1].split("/")[0])
        if not path.endswith("/results"):
            return self._anthropic_job(number)
        lines = [self._anthropic_line(request) for request in self.jobs[number]]
        return "application/x-jsonl", b"\n".join(reversed(lines)) + b"\n"  # in any order, as the vendor says

    def _anthropic_job(self, number: int) -> tuple[str, bytes]:
        self.looks[number] = self.looks.get(number, -1) + 1
        done = self.looks[number] > 0
        counts = {"processing": int(not done), "succeeded": int(done), "errored": 0, "canceled": 0, "expired": 0}
        times = {"created_at": "2026-01-01T00:00:00Z", "expires_at": "2026-01-02T00:00:00Z"}
        told = {"id": f"b{number}", "type": "message_batch", "request_counts": counts, **times}
        told["processing_status"] = "ended" if done else "in_progress"
        told["results_url"] = f"{self.url}/messages/batches/b{number}/results" if done else None
        return "application/json", json.dumps(told).encode()

    def _anthropic_line(self, request: dict[str, Any]) -> bytes:
        text = self._answers.pop(0)
        if text is None:
            refusal = {"type": "error", "error": {"type": "invalid_request_error", "message": "no"}}
            return json.dumps({"custom_id": request["custom_id"], "result": {"type": "errored", "error": refusal}}).encode()
        message = {"id": "m", "type": "message", "role": "assistant", "model": "claude", "stop_reason": "end_turn"}
        message |= {"content": [{"type": "text", "text": text}], "usage": {"input_tokens": 120, "output_tokens": 30}}
        message["stop_sequence"] = None
        return json.dumps({"custom_id": request["custom_id"], "result": {"type": "succeeded", "message": message}}).encode()


@contextmanager
def serving_batches(answers: Sequence[str | None], failing: str = " ") -> Iterator[BatchServer]:
    """A server of OpenAI's and Anthropic's batch protocols; None among the answers is a refusal.

    It fails where an address holds `failing`; none holds a blank.
    """
    served = BatchServer(answers)

    class Handler(BaseHTTPRequestHandler):
        def _answer(self, method: str) -> None:
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            protocol = served.anthropic if "/messages/batches" in self.path else served.openai
            failed = failing in self.path
            kind, content = ("text/plain", b"") if failed else protocol(method, self.path, body)
            self.send_response(500 if failed else 200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        def do_POST(self) -> None:
            self._answer("POST")

        def do_GET(self) -> None:
            self._answer("GET")

        def log_message(self, *_: object) -> None:
            """Silent."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    served.url = f"http://127.0.0.1:{server.server_port}/v1"
    try:
        yield served
    finally:
        server.shutdown()
        server.server_close()
        thread.join(5)
