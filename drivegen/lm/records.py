"""Record and replay: every reply is kept under a key made of everything it depends on, so that a rerun calls nobody.

A small JSON file each, `<folder>/<first two of the key>/<key>.json`, the same bytes for the same reply whenever it was
recorded: no times, no names of the vendor's. Pictures are kept as their SHA-256. Failures of transport are not replies and not
kept; replies that fail validation are, with the questions that followed.
"""

import hashlib
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import orjson

from drivegen.core.errors import MissingTool
from drivegen.lm.backends.base import Reply, Request
from drivegen.lm.prompt import DamagedRecord, Image
from drivegen.store.files import write_json

FORMAT = 1


class Mode(StrEnum):
    """replay: never call, what is not recorded is an error. auto: call for what is not recorded, and keep it.

    record: call always, and keep. off: call always, keep nothing.
    """

    REPLAY = "replay"
    AUTO = "auto"
    RECORD = "record"
    OFF = "off"


@dataclass(frozen=True)
class Records:
    """A folder of recorded replies, and how it is used."""

    folder: Path
    mode: Mode

    def find(self, request: Request) -> Reply | None:
        """The recorded reply; None where the model is to be called.

        Raises MissingTool naming the prompt where nothing is recorded and nobody may be called, DamagedRecord for a file that
        does not hold what was recorded.
        """
        if self.mode in (Mode.RECORD, Mode.OFF):
            return None
        file = self._file(key_of(request))
        if file.is_file():
            return _read(file)
        if self.mode is Mode.AUTO:
            return None
        raise MissingTool(
            f"{self.folder} holds no answer of {request.model} to {_shown(request)} (prompt {request.prompt_version}, key "
            f"{key_of(request)[:12]}): record it with lm.records.mode auto, or use `--lm offline`"
        )

    def keep(self, request: Request, reply: Reply) -> None:
        """Record a reply, except in mode off."""
        if self.mode is Mode.OFF:
            return
        reply_fields = {"text": reply.text, "input_tokens": reply.input_tokens, "output_tokens": reply.output_tokens}
        key = key_of(request)
        write_json(
            self._file(key),
            {"key": key, "request": fields_of(request), "reply": reply_fields, "sha256": _digest(reply_fields)},
        )

    def _file(self, key: str) -> Path:
        return self.folder / key[:2] / f"{key}.json"


def key_of(request: Request) -> str:
    """SHA-256 of the request as canonical JSON: model, prompt version, messages, schema, sample and output mode."""
    return _digest(fields_of(request))


def fields_of(request: Request) -> dict[str, Any]:
    """The request as plain values, pictures as their digests."""
    parts = [
        {"image": hashlib.sha256(part.content).hexdigest(), "media_type": part.media_type} if isinstance(part, Image) else part
        for part in request.parts
    ]
    return {
        "format": FORMAT,
        "model": request.model,
        "prompt_version": request.prompt_version,
        "instructions": request.instructions,
        "parts": parts,
        "turns": [{"reply": turn.reply, "complaint": turn.complaint} for turn in request.turns],
        "schema": request.schema,
        "output": request.output,
        "max_tokens": request.max_tokens,
        "sample": request.sample,
    }


def _read(file: Path) -> Reply:
    with suppress(ValueError, KeyError, TypeError):
        content = orjson.loads(file.read_bytes())
        reply_fields = content["reply"]
        if (content["key"], content["sha256"]) == (file.stem, _digest(reply_fields)):
            return Reply(reply_fields["text"], reply_fields["input_tokens"], reply_fields["output_tokens"], retries=0)
    raise DamagedRecord(f"{file} is no recorded reply, or was changed: delete it and record it again")


def _digest(value: Any) -> str:
    """SHA-256 of plain values as canonical JSON."""
    return hashlib.sha256(orjson.dumps(value, option=orjson.OPT_SORT_KEYS)).hexdigest()


def _shown(request: Request) -> str:
    text = " ".join(" ".join(part for part in request.parts if isinstance(part, str)).split())
    again = f", asked again {len(request.turns)} times" if request.turns else ""
    return repr(text if len(text) <= 120 else f"...{text[-117:]}") + again
