"""What language models were asked, what it cost, and what it may cost: a row per call, a guard before each."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from uuid import uuid4

import pyarrow as pa

from drivegen.lm.prompt import OverBudget
from drivegen.store.files import write_table

FOLDER = Path(".drivegen/calls")
"""Where tables of calls are kept, a file for each run of a stage or a command that called."""

UNKNOWN = "unknown"
"""The cost of a call where no price list knows the model."""

CALLS = pa.schema(
    [
        ("role", pa.string()),
        ("model", pa.string()),
        ("prompt_version", pa.string()),
        ("key", pa.string()),
        ("sample", pa.int64()),
        ("asked", pa.int64()),
        ("outcome", pa.string()),
        ("replayed", pa.bool_()),
        ("input_tokens", pa.int64()),
        ("output_tokens", pa.int64()),
        ("cost", pa.string()),
        ("latency", pa.float64()),
        ("retries", pa.int64()),
    ]
)
"""Columns of a table of calls; see `Call`."""


@dataclass(frozen=True)
class Call:
    """One call of a model, or one answer from the records; what is known only after it has a default.

    Attributes:
        asked: 0 for the question, 1 and 2 when asked again. outcome: "answered", "asked again", "interrupted" or
            why there was no answer.
        cost: dollars as text, or "unknown", as where an attempt had no response, which may be billed all the same; 0 for what
            was replayed or is not billed. latency: [s], of a batch each call's share. retries: of the transport.
    """

    role: str
    model: str
    prompt_version: str
    key: str
    sample: int
    asked: int
    outcome: str = ""
    replayed: bool = False
    input_tokens: int | None = None
    output_tokens: int | None = None
    cost: str = UNKNOWN
    latency: float = 0.0
    retries: int = 0


class Ledger:
    """The calls of one role, in the order of their ends, and the guard over its budget; safe to use from several threads.

    What a call could cost at most is set aside before it begins, so calls at the same time cannot overspend together. Where the
    price is unknown only the number of calls is guarded.
    """

    def __init__(self, max_usd: float, max_calls: int) -> None:
        self.calls: list[Call] = []
        self._max_usd, self._max_calls = max_usd, max_calls
        self._spent, self._made = 0.0, 0
        self._lock = threading.Lock()

    def set_aside(self, usd: float | None) -> None:
        """Before a call that costs at most `usd` (None unknown). Raises OverBudget where that might be too much."""
        with self._lock:
            if self._made >= self._max_calls:
                raise OverBudget(f"{self._made} calls of the language model were made, as many as max_calls allows: raise it")
            if usd is not None and self._spent + usd > self._max_usd:
                raise OverBudget(
                    f"the next call may cost {usd:.4f} dollars and {self._spent:.4f} of {self._max_usd:g} are spent: "
                    "raise --max-usd"
                )
            self._made += 1
            self._spent += usd or 0.0

    def settle(self, set_aside: float | None, usd: float | None, more: int = 0) -> None:
        """After that call: what it did cost; where that is unknown, what was set aside stays spent.

        So many `more` attempts may be billed, too: each counts as a call that cost what was set aside.
        """
        with self._lock:
            self._made += more
            if set_aside is not None:
                self._spent += more * set_aside + (0.0 if usd is None else usd - set_aside)

    def add(self, call: Call) -> None:
        """Note a call."""
        with self._lock:
            self.calls.append(call)

    def table(self) -> pa.Table:
        """The calls, a column per field of `Call`."""
        return pa.Table.from_pylist([asdict(call) for call in self.calls], schema=CALLS)

    @contextmanager
    def kept(self, run: str) -> Iterator[None]:
        """Write the calls below `FOLDER` at the end of the block, also where it ends in an error; nothing where there were none.

        `run` begins the file's name. Where somebody was asked the file is a new one, so no row of a run that cost something is
        lost; else it takes the place of the last such, for replays of the same answers may be many.
        """
        try:
            yield
        finally:
            if self.calls:
                asked = any(not call.replayed and call.outcome != "no-model" for call in self.calls)
                self.write(FOLDER / (f"{run}-{uuid4().hex[:12]}.parquet" if asked else f"{run}.parquet"))

    def write(self, path: Path) -> None:
        """The calls as Parquet; latencies differ from run to run, so this is no output of a stage."""
        write_table(path, self.table())
