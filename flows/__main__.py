"""`python -m flows experiment|regenerate|iterate|corpus|gate|tables`: run one flow with a local Prefect server around it."""

import argparse
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from flows import attended, server
from flows.rooms import PARTS, QUALITY

MADE: dict[str, Callable[[Any], str]] = {
    "experiment": lambda _: f"Report: {Path('reports/index.html').resolve()}",
    "regenerate": lambda state: f"New version: {Path(state.result()).resolve()}",
    "iterate": lambda state: f"Collision rate of each round: {', '.join(f'{rate:.3f}' for rate in state.result())}",
    "corpus": lambda state: f"Scenarios: {Path(state.result()).resolve()}",
    "gate": lambda state: str(state.message),
    "tables": lambda state: str(state.message),
}
"""What each flow says it has made."""


def main(argv: list[str]) -> int:
    """0 if the flow completed, 1 with its reason otherwise, 128 and its number where a signal stopped it (130 is Ctrl-C)."""
    arguments = _parser().parse_args(argv)
    try:
        imports = partial(import_module, f"flows.{arguments.flow}")
        with _stoppable(), attended.stopping_work(), server.local_server(meanwhile=imports):
            state = _run(arguments)
    except (RuntimeError, OSError) as error:
        print(f"flows: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as stop:
        print("flows: stopped; stages that were done stay done, the same command goes on from there", file=sys.stderr)
        return 128 + (stop.number if isinstance(stop, Stopped) else signal.SIGINT)
    if not state.is_completed():
        print(f"flows: {arguments.flow}: {state.message}", file=sys.stderr)
        return 1
    print(MADE[arguments.flow](state))
    return 0


class Stopped(KeyboardInterrupt):
    """A signal that asks us to stop."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextmanager
def _stoppable() -> Iterator[None]:
    """Signals that ask us to stop raise `Stopped`, also those that would end us on the spot.

    What is interrupted may fail as it cleans up ("release unlocked lock", where it was about to take one): `Stopped`, too.
    """
    stopped: list[int] = []

    def stop(number: int, _: object) -> None:
        stopped.append(number)
        raise Stopped(number)

    before = {number: signal.signal(number, stop) for number in attended.STOPS}
    try:
        yield
    except (RuntimeError, OSError) as error:
        if stopped:
            raise Stopped(stopped[0]) from error
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m flows", description=__doc__)
    flows = parser.add_subparsers(dest="flow", required=True)
    flows.add_parser("experiment", help="bring every stage up to date")
    regenerate = flows.add_parser("regenerate", help="a new version of the generated data set, from new seeds")
    regenerate.add_argument("--version", help="name of the version; today's date if not given")
    regenerate.add_argument("--seed", type=int, help="the seed; made from the version if not given")
    iterate = flows.add_parser("iterate", help="corner-case rounds until the collision rate stops rising")
    iterate.add_argument("--min-gain", type=float, default=0.0, help="a round must raise the rate by more than this")
    corpus = flows.add_parser("corpus", help="the corpus in another size, simulated and ingested in a workspace of its own")
    corpus.add_argument("size", help="its name in flows/sizes.yaml")
    flows.add_parser("gate", help="whether the new driver of stages/params.yaml, `gate`, is worse than the old one: exit code 1")
    tables = flows.add_parser("tables", help="the published tables: all data sets, several training seeds")
    real = os.environ.get("DRIVEGEN_REAL_DATA") or Path("../shared/data")  # a word is checked as one that was typed
    for flow in (corpus, tables):
        about_real = "folder of real data; what it lacks is left out (flows/tables.yaml and flows/sizes.yaml say which folders)"
        flow.add_argument("--real", type=_folder, default=real, help=about_real)
    about_parts = "quality: scenarios of all methods; maps: single pieces; drivers: tables of them; corner: corner cases; "
    tables.add_argument("--part", choices=PARTS, default=QUALITY, help=about_parts + "rates: how often drivers fail")
    return parser


def _folder(word: str) -> Path:
    """An option's folder: one that was named and is not there must not look like one that was left out."""
    if not Path(word).is_dir():
        raise argparse.ArgumentTypeError(f"{word} is no folder")
    return Path(word)


def _run(arguments: argparse.Namespace) -> Any:
    """The final state of the flow. It is imported here because Prefect reads its settings on import."""
    options = {name: value for name, value in vars(arguments).items() if name != "flow"}
    flow = getattr(import_module(f"flows.{arguments.flow}"), arguments.flow)
    return flow(**options, return_state=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
