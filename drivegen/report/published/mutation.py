"""The mutation score of traffic and adversaries, published: rows over several seeds, one table, one chart."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from drivegen.core import plugins
from drivegen.core.methods import read_methods
from drivegen.report import plots
from drivegen.report.published.figures import title_of
from drivegen.report.published.seeds import mean_of_all
from drivegen.report.table import Cell, Row, Table, number, row

SHARES = ("killed", "killed_apart", "false_kills", "false_kills_apart", "named", "named_by_guess")
NUMBERS = ("first_kill", "runs_to_kill", "runs", "recordings")
OF_DRIVERS = ("p", "killed", "only_mutant", "only_sound", "named", "runs_to_kill", "runs")

LOG, NAME = "log", "mutation-score"

Scores = Mapping[str, dict[str, Any]]
"""What `metrics.mutation_score.scored` says of each tester of one run."""


def mutation_rows(data: str, runs: Sequence[Scores]) -> Iterator[dict[str, Any]]:
    """Rows {data, tester, driver, metric, value, n, seeds}, a run a seed; `driver` is "" for what is of all of them.

    Values are means over seeds, None where there is none in one of them: too few runs, or nothing that it could be a share of.
    n is the number of drivers.
    """
    for tester, first in runs[0].items():
        about = {"data": data, "tester": tester, "seeds": len(runs)}
        for metric in (*SHARES, *NUMBERS):
            drivers = first["equivalent" if metric.startswith("false") else "faulty"]
            yield {
                **about,
                "driver": "",
                "metric": metric,
                "value": mean_of_all([run[tester][metric] for run in runs]),
                "n": drivers,
            }
        for name in first["drivers"]:
            for metric in OF_DRIVERS:
                value = mean_of_all([run[tester]["drivers"][name][metric] for run in runs])
                yield {**about, "driver": name, "metric": metric, "value": value, "n": 1}


def mutation_table(scores: Scores) -> Table:
    """All testers of one run, whoever kills most first, with their curves."""
    order = sorted(scores, key=lambda tester: (-(scores[tester]["killed"] or 0.0), tester))
    adversaries, methods = plugins.names("adversaries"), read_methods()

    def title(tester: str) -> str:
        if tester == LOG:
            return "logs"
        return title_of(tester) if tester in adversaries else methods[tester].title

    first = scores[order[0]]
    still, searching = ({title(t): scores[t]["curve"] for t in order if (t in adversaries) == search} for search in (False, True))
    return Table(
        NAME,
        "Mutation score: which faulty drivers does a tester tell from the sound ones?",
        (
            "tester",
            "searches",
            "runs of each driver",
            f"of {first['faulty']} faulty killed",
            f"of {first['equivalent']} equivalent killed",
            "right kind named",
            "had one kind been named for all",
            "runs to the first kill",
            "runs to half of the faulty",
            "killed / equivalent killed, were runs independent",
        ),
        tuple(_line(title(tester), tester in adversaries, scores[tester]) for tester in order),
        _notes(first["level"]),
        picture=plots.two_kinds(still, searching, "runs of each driver", "faulty drivers killed (dashed: searches)"),
    )


def _line(title: str, searches: bool, score: Mapping[str, Any]) -> Row:
    beyond = f"more than {number(round(score['runs']))}"
    first, half = (beyond if score[name] is None else number(int(score[name])) for name in ("first_kill", "runs_to_kill"))
    names = ("killed", "false_kills", "named", "named_by_guess", "killed_apart", "false_kills_apart")
    killed, false, named, guess, *apart = ("-" if score[name] is None else f"{score[name]:.0%}" for name in names)
    of = Cell(number(round(score["runs"])), f"{score['recordings']} recordings")
    return row(title, "yes" if searches else "no", of, killed, false, named, guess, first, half, " / ".join(apart))


def _notes(level: float) -> tuple[str, ...]:
    return (
        "Killed: more avoidable counted collisions than the sound driver has, by McNemar's exact test (one-sided, recordings as "
        f"clusters) and by Holm at {level:.0%} over all drivers of a tester, equivalent ones included. Logs and generated "
        "traffic are the same for both and spread their runs over all scenarios, a search makes ten or so in one, so it sees "
        "fewer. Who searches does so as long against the driver that is tested as against the sound one, from the same scenes, "
        "and all runs count; where one of the two has more of them in a scenario, its last ones are left out. Equivalent "
        "drivers do the same as the sound one by other code, so none can be killed: they show that runs repeat, not how often a "
        "driver is killed that differs without being worse.",
        "Right kind: among the killed, the kind of collision of the largest excess was declared for the fault before it was "
        "driven. Most faults fail by running into somebody ahead: beside it stands how often the kind that fits best is right.",
        "Runs to a kill: the fewest of the runs in the chart after which half of the random orders of scenarios have killed; "
        "each number of runs is a test of its own, nobody stops early.",
    )
