"""The table of contents of the published tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from drivegen.report.table import Table

_RUN = "A run is a data set with seeds of training and sampling (ngsim/8-17) or a temperature of DriveGen's goals (ngsim/t0.5)."
_FILES = (
    "* [`scenario_quality.json`](scenario_quality.json): every figure with its interval",
    "* [`provenance.json`](provenance.json): which runs, of which code, by which versions",
)


def index(tables: Sequence[Table], data: Mapping[str, str], provenance: Mapping[str, Any], parts: Sequence[str] = ()) -> str:
    """The tables as links: by data set (title by name, the headline's first), what concerns several, other `parts`, raw files."""
    there, missing = len(provenance["runs"]), provenance["runs_missing"]
    whole_set = f"From all {there} runs that flows/tables.yaml asks for."
    partial = f"INCOMPLETE: from {there} of {there + len(missing)} runs; not there: {', '.join(missing)}."
    lines = ["# Published tables", "", f"{partial if missing else whole_set} Of code {_codes(provenance)}. {_RUN}"]
    rest = list(tables)
    for title in data.values():
        mine = [table for table in rest if table.title.endswith(f": {title}")]
        rest = [table for table in rest if table not in mine]
        if mine:
            lines += ["", f"## {title}", "", *(_link(table, table.title.removesuffix(f": {title}")) for table in mine)]
    if rest:
        lines += ["", "## Across data sets", "", *(_link(table, table.title) for table in rest)]
    if parts:
        lines += ["", "## Other parts", "", "Each is of code of its own, which its page names.", ""]
        lines += [f"* [{part.capitalize()}]({part}.md)" for part in parts]
    return "\n".join([*lines, "", "## Raw", "", *_FILES, ""])


def part_index(part: str, title: str, tables: Sequence[Table], provenance: Mapping[str, Any]) -> str:
    """The tables of one part as links, and what they were made from."""
    runs, missing = ", ".join(provenance["runs"]), ", ".join(provenance["runs_missing"])
    made = f"Runs: {runs}; of code {_codes(provenance)}. [Hashes and versions](provenance-{part}.json)."
    lines = [f"# {title}", "", f"INCOMPLETE, not there: {missing}. {made}" if missing else made, ""]
    return "\n".join([*lines, *(_link(table, table.title) for table in tables), ""])


def _codes(provenance: Mapping[str, Any]) -> str:
    """The commits that made the runs."""
    codes = [f"{code['commit']}{' and uncommitted changes' if code['changed'] else ''}" for code in provenance["code"]]
    return ", ".join(codes) or "unknown"


def _link(table: Table, words: str) -> str:
    return f"* [{words}]({table.name}.md)"
