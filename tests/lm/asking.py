"""A question, and a role that asks a server of the tests."""

from collections import Counter
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from drivegen.lm.model import LanguageModel
from drivegen.lm.prompt import Image, Prompt, fenced
from drivegen.lm.records import Mode, Records
from drivegen.lm.settings import RoleSettings

PIXEL = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x40\0\0\0\x20"


class Choice(BaseModel):
    """Which of three places."""

    model_config = ConfigDict(extra="forbid")
    place: Annotated[int, Field(ge=1, le=3)]
    reason: str = ""


GOOD = '{"place": 2, "reason": "free"}'


def question(words: str = "where to?", **more: Any) -> Prompt[Choice]:
    parts = (fenced("words", words), Image(PIXEL, "image/png"))
    return Prompt(version="test-1", instructions="Choose a place from 1 to 3.", parts=parts, answer=Choice, **more)


def settings(base_url: str = "", **more: Any) -> RoleSettings:
    values = {
        "backend": "openai",
        "model": "little-model",
        "base_url": base_url,
        "key": "",
        "output": "native",
        "prompt": "test-1",
        "max_tokens": 200,
        "timeout": 5.0,
        "retries": 2,
        "max_usd": 1.0,
        "max_calls": 20,
        "batch": False,
    }
    return RoleSettings(**{**values, **more})


def outcomes(asked: LanguageModel) -> Counter[str]:
    """How many calls ended how."""
    return Counter(call.outcome for call in asked.ledger.calls)


def model(folder: Path, base_url: str = "", mode: Mode = Mode.AUTO, **more: Any) -> LanguageModel:
    return LanguageModel("goals", settings(base_url, **more), Records(folder, mode))
