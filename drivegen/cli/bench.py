"""`drivegen bench`: speed, each row beside a reference measured in the same run; `drivegen bench maps`: maps from words."""

import os
from pathlib import Path
from typing import Annotated, Any

from rich.console import Console
from rich.table import Table
from typer import Context, Exit, Option, Typer

from drivegen.bench import measure, unmeasured
from drivegen.cli._files import MAPS, SPEED, expect_own
from drivegen.cli._lm import MaxUsd, Words, announce, calling
from drivegen.cli._maps import MapMode, Mode, writer_of
from drivegen.core.seeds import LARGEST
from drivegen.lm.prices import MAP_TOKENS
from drivegen.maps.suite.cases import Case, outside_cases, own_cases
from drivegen.maps.suite.table import COUNTS, not_measured, published, seconds
from drivegen.maps.suite.trials import tried
from drivegen.maps.writers.base import ROUNDS, MapWriter
from drivegen.store.files import write_json
from drivegen.words.judge import traffic_lacking
from drivegen.words.writer import Writer, asking_writer

command = Typer(rich_markup_mode=None)

_WIDTH = 120
"""Of the table of maps at least, also where it goes to a file: what is cut off cannot be read."""


@command.callback(invoke_without_command=True)
def speed(
    context: Context,
    json: Annotated[Path | None, Option(help="Also write the rows to this JSON file.")] = None,
    only: Annotated[str, Option(help="Only the rows of one part, e.g. raster.")] = "",
) -> None:
    """Print rows {name, value, unit, reference, ratio, target, pass}; exits 1 if a row misses its target."""
    if context.invoked_subcommand is not None:
        return
    if json is not None:
        expect_own(json, SPEED)
    with Console(stderr=True).status("measuring ..."):
        rows = list(measure(only))
    table = Table("name", "value", "unit", "reference", "ratio", "target", "", box=None, pad_edge=False)
    for row in rows:
        target = "" if row.target is None else f"{'<=' if row.smaller_is_better else '>='} {row.target:g}"
        reference = "" if row.reference is None else f"{row.reference:.4g} ({row.reference_name})"
        ratio = "" if row.ratio is None else f"{row.ratio:.1f}x"
        verdict = "" if row.target is None else "pass" if row.passed else "MISS"
        table.add_row(row.name, f"{row.value:.4g}", row.unit, reference, ratio, target, verdict)
    Console().print(table)
    for sentence in unmeasured():
        Console(stderr=True).print(sentence)
    if json is not None:
        write_json(json, [row.as_json() for row in rows])
    if not all(row.passed for row in rows):
        raise Exit(1)


@command.command()
def maps(
    lm: Words = None,
    map_mode: MapMode = Mode.SPECIFICATION,
    max_usd: MaxUsd = None,
    json: Annotated[Path | None, Option(help="Also write the table to this JSON file.")] = None,
    outside: Annotated[
        Path | None, Option(metavar="DIR", help="A folder with map_prompts.jsonl and its judge check_map.py.")
    ] = None,
    seed: Annotated[int, Option(min=0, max=LARGEST, help="What descriptions leave open is drawn from it.")] = 7,
    every: Annotated[int, Option(min=1, help="Only every n-th description.")] = 1,
) -> None:
    """How often words become what they ask for, at once and after the offered sentence, by the phrase table and by --lm."""
    if json is not None:
        expect_own(json, MAPS)
    folder = outside or _beside_the_real_data()
    cases = [*own_cases(), *(outside_cases(folder) if folder else [])][::every]
    results = [_tried(Writer(), cases, seed)]
    if lm is None:
        results.append(not_measured("language model"))
    else:
        with calling("bench-maps", "maps", lm, max_usd) as model:
            writer = asking_writer(writer_of(map_mode), model)
            announce(model, writer.first_questions(case.text for case in cases), MAP_TOKENS, ROUNDS)
            results.append(_tried(writer, cases, seed))
    for one in results:
        _print(one)
    if json is not None:
        write_json(json, {"descriptions": len(cases), "writers": results})


def _beside_the_real_data() -> Path | None:
    """The folder `benchmarks` beside that of the real data, where there is one."""
    data = os.environ.get("DRIVEGEN_REAL_DATA")
    folder = Path(data).parent / "benchmarks" if data else None
    return folder if folder and folder.is_dir() else None


def _tried(writer: MapWriter, cases: list[Case], seed: int) -> dict[str, Any]:
    with Console(stderr=True).status(f"{len(cases)} descriptions: {writer.description} ..."):
        trials = tried(cases, writer, seed, traffic_lacking)
    return {**published(writer.description, trials), "cpu_seconds": seconds(trials)}


def _print(result: dict[str, Any]) -> None:
    console = Console(width=max(Console().width, _WIDTH))
    console.print(f"written by: {result['written_by']}", highlight=False, markup=False)
    if not result["measured"]:
        console.print("not measured: name a model with --lm\n", highlight=False)
        return
    table = Table("", *(name.replace("_", " ") for name in COUNTS), "CPU s each", box=None, pad_edge=False)
    for name, counts in result["groups"].items():
        table.add_row(name, *(str(counts[column]) for column in COUNTS), f"{result['cpu_seconds'][name]:.2f}")
    console.print(table)
    for case in result["failed"]:
        why = case["refused"] or "; ".join(case["wrong"])
        word = "declined" if case["refused"] else "WRONG"
        console.print(f"{word}: {case['group']}: {case['text']}: {why}", highlight=False, markup=False, soft_wrap=True)
    console.print()
