"""How each role uses a language model, from params.yaml: sections lm.maps, lm.goals, lm.corner_cases and lm.records."""

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.lm.backends.base import Output
from drivegen.lm.records import Mode, Records

ROLES = ("maps", "goals", "corner_cases")
"""What language models are asked for: roads from words, vehicles' goals, goals that lead to corner cases."""

_VARIABLE = re.compile(r"[A-Z][A-Z0-9_]*")


@dataclass(frozen=True)
class RoleSettings:
    """One role.

    Attributes:
        backend: a file in drivegen/lm/backends. model: its name there ("" for offline).
        base_url: of an OpenAI-compatible server, e.g. "http://127.0.0.1:8000/v1"; "" is the vendor's own.
        key: NAME of the environment variable that holds the key, never the key; "" where none is needed.
        output: how the answer's schema reaches the model: natively, as a tool, or in words, which any server understands.
        prompt: version of the wording.
        max_tokens: of one answer. timeout: of one attempt [s]. retries: of an attempt that failed on the way.
        max_usd, max_calls: what a run may spend; calls count where the price is unknown, too.
        batch: whether stages ask what they know together through the vendor's batch endpoint: half the price, within a day.
    """

    backend: str
    model: str
    base_url: str
    key: str
    output: str
    prompt: str
    max_tokens: int
    timeout: float
    retries: int
    max_usd: float
    max_calls: int
    batch: bool

    def __post_init__(self) -> None:
        if self.backend not in (names := plugins.names("lm.backends")):
            raise UnusableInput(f"lm: no backend is called {self.backend!r}: choose one of {', '.join(names)}")
        if self.output not in get_args(Output):
            raise UnusableInput(f"lm: output is one of {', '.join(get_args(Output))}, not {self.output!r}")
        if self.key and not _VARIABLE.fullmatch(self.key):  # perhaps the key itself: not repeated here
            raise UnusableInput("lm: `key` is the name of an environment variable, such as OPENAI_API_KEY, never the key itself")
        if (self.backend == "offline") != (not self.model):
            raise UnusableInput(f"lm: the backend {self.backend} {'needs the' if not self.model else 'has no'} name of a model")
        if min(self.max_tokens, self.timeout) <= 0 or min(self.retries, self.max_usd, self.max_calls) < 0:
            raise UnusableInput("lm: max_tokens and timeout must be positive; retries, max_usd, max_calls not negative")


@dataclass(frozen=True)
class RecordSettings:
    """Where replies are kept, and when they are used instead of a call: see `drivegen.lm.records.Mode`."""

    mode: str
    folder: str

    def open(self) -> Records:
        """The records. Raises UnusableInput for an unknown mode."""
        try:
            mode = Mode(self.mode)
        except ValueError:
            raise UnusableInput(f"lm.records: mode is one of {', '.join(Mode)}, not {self.mode!r}") from None
        return Records(Path(self.folder), mode)


def overridden(settings: RoleSettings, words: str) -> RoleSettings:
    """The role with another model, as `--lm` says it: "offline", "anthropic:MODEL", "openai:MODEL[@BASE_URL]".

    A base URL in the words needs no key; without one the vendor's usual variable is read.
    """
    backend, _, rest = words.partition(":")
    model, _, base_url = rest.partition("@")
    key = "" if base_url or backend == "offline" else f"{backend.upper()}_API_KEY"
    if backend == settings.backend and not base_url:
        key, base_url = settings.key, settings.base_url
    return replace(settings, backend=backend, model=model, base_url=base_url, key=key)
