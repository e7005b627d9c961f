"""The ways in which DriveGen says no, each with one sentence that names file, place and remedy."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class DriveGenError(Exception):
    """Something failed for a reason the user can act on (exit code 1)."""

    exit_code = 1

    def __reduce__(self) -> tuple[Any, ...]:
        """As it stands, without asking its class again: processes hand errors to one another, whatever their arguments were."""
        return _as_it_was, (type(self), self.args, self.__dict__)


def _as_it_was(kind: type[Exception], args: tuple[Any, ...], state: dict[str, Any]) -> Exception:
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(state)
    return error


class MissingTool(DriveGenError):
    """A program, trained weights or disk space that the work needs is not there (exit code 1)."""


class UnusableInput(DriveGenError):
    """A request was not understood or a file cannot be used (exit code 2).

    `reason` is a short stable word (`truncated`, `no-lanes`, ...): it is what rejected scenarios are counted by.
    """

    exit_code = 2

    def __init__(self, message: str, reason: str = "unusable") -> None:
        super().__init__(message)
        self.reason = reason


@contextmanager
def naming(place: object) -> Iterator[None]:
    """Put `place` before the sentence of an UnusableInput that is raised inside."""
    try:
        yield
    except UnusableInput as error:
        raise UnusableInput(f"{place}: {error}", reason=error.reason) from None
