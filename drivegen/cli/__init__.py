"""The command `drivegen`: single pieces of the pipeline by hand, one file a command. Nobody imports this package.

Only the command that is asked for is imported: the others' libraries cost seconds, and the doctor must be able to speak
when one of them is broken.
"""

import errno
import importlib
import importlib.metadata
import io
import os
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Annotated, Any

import typer

from drivegen.core.errors import DriveGenError, UnusableInput

COMMANDS = {
    "map": "Roads from words or files, edits, other formats.",
    "generate": "Traffic: a log again, a network, words.",
    "corner": "What makes a driver fail, by kind.",
    "rate": "How often a driver fails, from few runs.",
    "gate": "Whether a driver collides more than another.",
    "export": "The pipeline's scenarios as folders.",
    "view": "Look at a scenario folder or a log.",
    "query": "SQL over all results.",
    "estimate": "What language models would cost.",
    "weights": "Trained models as one file, to carry along.",
    "doctor": "What is installed, what is missing.",
    "bench": "How fast it is; maps from words as asked.",
}
"""What each is for, short enough for the list of `drivegen --help`."""

_REMEDIES = {
    errno.ENOSPC: ": make room, or name another disk",
    errno.EROFS: ": name a folder that can be written to",
    errno.EACCES: ": name a place that you may use",
    errno.EPERM: ": name a place that you may use",
    errno.ENOENT: ": name a place that is there and can be written to",
    errno.ENAMETOOLONG: ": choose a shorter name",
    errno.ENOTEMPTY: ": another run wrote it meanwhile, name another folder",
}

_UNUSABLE_PLACES = (errno.EROFS, errno.EACCES, errno.EPERM, errno.ENOENT, errno.ENAMETOOLONG)
"""With these it is the words of the command line that are at fault (exit code 2)."""


def main() -> None:
    """The console script: whatever goes wrong is one sentence on stderr and an exit code, never a traceback."""
    os.environ.setdefault("RUST_LOG", "off")  # what fails in Rerun is told below, once
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names that the terminal cannot show
    try:
        with _stoppable(), warnings.catch_warnings():
            warnings.showwarning = _told  # type: ignore[assignment]  # it needs the message alone
            _expect_no_empty_place(sys.argv[1:])
            build(sys.argv[1:])()
    except DriveGenError as error:
        _leave(str(error), error.exit_code)
    except ImportError as error:
        _leave(f"{error.name or 'a package'} cannot be imported: `drivegen doctor` says what to do", 1)
    except MemoryError as error:
        _leave(f"there is not enough memory for that ({error}); nothing half-written was kept: ask for less", 1)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        what = (error.strerror or str(error)).splitlines()[0]
        code = 2 if error.errno in _UNUSABLE_PLACES else 1
        _leave(f"{where}{what}; nothing half-written was kept{_REMEDIES.get(error.errno or 0, '')}", code)


def build(words: list[str]) -> typer.Typer:
    """The command line with the command that `words` begin with; without one, with the list of all, none of them imported."""
    app = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.callback(context_settings={"help_option_names": ["-h", "--help"]})(drivegen)
    if not words or words[0] not in COMMANDS:
        for name, purpose in COMMANDS.items():
            app.command(name, short_help=purpose)(_listed)
        return app
    name = words[0]
    command = importlib.import_module(f"drivegen.cli.{name}").command
    if isinstance(command, typer.Typer):  # one with commands of its own
        app.add_typer(command, name=name, short_help=COMMANDS[name])
    else:
        app.command(name, short_help=COMMANDS[name])(command)
    return app


def _listed() -> None:
    """What stands for a command in the list of them: importing all of their libraries takes seconds."""


def _version(show: bool) -> None:
    if show:
        typer.echo(f"drivegen {importlib.metadata.version('drivegen')}")
        raise typer.Exit


def drivegen(
    _: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")] = False,
) -> None:
    """Traffic scenarios for autonomous driving: roads from words, traffic from goals, corner cases for a driver.

    Exit codes: 0 done; 1 failed (a missing tool or weights, a full disk); 2 the request was not understood or the
    input is unusable; 3 `gate` finds the new driver worse, 4 with --strict does not tell it apart; 128 and a signal's
    number: stopped by it.
    """


def _told(message: Warning | str, *_: Any) -> None:
    """A warning is one line, too, without the place in our code."""
    sys.stderr.write(f"drivegen: {' '.join(str(message).split())}\n")


def _expect_no_empty_place(words: list[str]) -> None:
    """An empty path would be the current folder."""
    if "--out=" in words or ("--out", "") in pairwise(words):
        raise UnusableInput("--out is empty: name a file or a folder")


@contextmanager
def _stoppable() -> Iterator[None]:
    """Ctrl-C, SIGTERM and SIGHUP end the block as an error would; who ignores one, as nohup does, goes on ignoring it.

    Whatever a library makes of that, the exit code is the signal's.
    """
    stops: list[int] = []

    def stopped(number: int, _: object) -> None:
        """Leave, so that what is half-written is removed."""
        stops.append(number)
        _leave("stopped; nothing half-written was kept", 128 + number)

    ending = (signal.SIG_DFL, signal.default_int_handler)
    before = {stop: signal.getsignal(stop) for stop in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    before = {stop: handler for stop, handler in before.items() if handler in ending}
    for stop in before:
        signal.signal(stop, stopped)
    try:
        yield
    except BaseException:
        if stops:
            sys.exit(128 + stops[0])
        raise
    finally:
        for stop, handler in before.items():
            signal.signal(stop, handler)


def _leave(sentence: str, code: int) -> None:
    sys.stderr.write(f"drivegen: {sentence}\n")
    sys.exit(code)
