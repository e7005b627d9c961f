"""Adversaries: what each finds that makes a driver collide, in the same scenes, with at most as many runs."""

from collections.abc import Mapping
from typing import Any

from drivegen.report.evidence import Evidence
from drivegen.report.section import Section, not_measured
from drivegen.report.table import Table, measured, number, row, taken

SHARES = ("collision", "counted", "avoidable", "legal_share", "survives_reaction")

COLUMNS = {
    "CR": "collision",
    "Dis [m]": "distance",
    "Comfort": "comfort_absolute",
    "Div": "spread_over_runs",
    "counted": "counted",
    "of scenes avoidable": "avoidable",
    "of cases legal": "legal_share",
    "of cases hold when all react": "survives_reaction",
    "natural odds": "odds",
}
"""Columns -> names in the stage's JSON."""

OURS = "drivegen_cs"

NOTES = (
    "One run of each scene is handed over: the first that counts and could have been avoided, else the first that counts, else "
    "the first with a collision, else the last.",
    "Counted: front, side, or hit in the side after the first second; not run into from behind or while standing, as replays do.",
    "Runs are all runs of the driver in a scene, those that only look at how it drives included; no method has more.",
    "Where a scenario has several generated scenes (`attack.samples`) these share its runs: DriveGen-CS and CAT take one more "
    "for every so many runs (`per_scene`), random goals are drawn from all, AdvSim and DiffScene spend all on the first, and "
    "on one vehicle in it.",
    "The numbers of DriveGen-CS, CAT and AdvSim were chosen on training and validation scenes of the same corpus (LOG.md), those "
    "of DriveGen-CS among more than theirs; DiffScene's were not.",
)


def section(evidence: Evidence) -> Section:
    """Every driver that was attacked."""
    drivers = {name: value for name, value in evidence.below("attack").items() if isinstance(value, Mapping)}
    lead = (
        "DriveGen-CS beside its rivals: the same first frames and traffic, at most the same number of runs. Neighbours "
        "are replayed but for the attacker's exchanged motion; what survives when all react stands beside it. Nothing is trained."
    )
    tables = []
    for name, values in drivers.items():
        tables += [outcome_table(name, values), *proposer_tables(name, values), cost_table(name, values, evidence.costs)]
    return Section("attack", "Adversaries", lead, tuple(tables), missing="" if drivers else not_measured("attack"))


def outcome_table(driver: str, attacks: Mapping[str, dict[str, Any]]) -> Table:
    """Table III, extended."""
    lines = [
        row(
            values["title"],
            _allowed(values),
            number(values["budget"]),
            *(measured(values, key, 3 if key in SHARES else 2) for key in COLUMNS.values()),
            number(values["kinds"]),
            origin="ours" if values["method"] == OURS else "rival",
        )
        for values in attacks.values()
    ]
    heads = ("", "allowed", "runs a scene", *COLUMNS, "kinds")
    stand_ins = {f"{values['title']}: {values['stand_in']}." for values in attacks.values() if values["stand_in"]}
    title = f"Table III, extended. What makes {driver} collide"
    return Table(f"attack-{driver}", title, heads, tuple(lines), (*NOTES, *sorted(stand_ins)))


def proposer_tables(driver: str, attacks: Mapping[str, dict[str, Any]]) -> list[Table]:
    """Counted shares by who proposes, what varies and what is allowed; none where nobody proposes goals as well as motions."""
    cells = {(v["proposer"], v["varies"], v["allowed"], v["budget"]): v for v in attacks.values() if v.get("proposer")}
    crossed = {who for who, varies, *_ in cells if varies == "goals"} & {who for who, varies, *_ in cells if varies == "motions"}
    if not crossed:
        return []
    columns = sorted({(varies, allowed) for _, varies, allowed, _ in cells})
    lines = []
    for who, budget in dict.fromkeys((who, budget) for who, _, _, budget in cells):
        figures = [cells.get((who, *column, budget)) for column in columns]
        lines.append(row(who, number(budget), *(measured(each, "counted", 3) if each else "-" for each in figures)))
    heads = ("", "runs a scene", *(f"{varies}, {allowed}" for varies, allowed in columns))
    note = (
        "Share of scenes with a counted collision. Goals are planned by DriveGen; motions are the same tracks with other "
        "accelerations and curvatures. What each chooses from differs: chance from as many as there are goals, of either kind; "
        "who ranks goals from these and variations of the best (`variation`); who ranks motions from several for each goal "
        "(`draws`); cross-entropy from so many for each run (`tries`), of one vehicle. Physical asks for what bodies can do and "
        "for no collision between others, legal for every rule of the checker but giving way to the driver, who may be anywhere "
        "by then."
    )
    title = f"Who proposes, what varies, what is allowed: collisions of {driver}"
    return [Table(f"attack-{driver}-proposers", title, heads, tuple(lines), (note,))]


def cost_table(driver: str, attacks: Mapping[str, dict[str, Any]], costs: Mapping[str, Mapping[str, float]]) -> Table:
    """Table IV, like with like: search and rehearsal on all sides."""
    lines = []
    for key, values in attacks.items():
        took = dict(costs.get(f"attack/{driver}-{key}", {}))
        if took:
            took["per_1000"] = 1000 * took["cpu_seconds"] / values["scenarios"]
        if took.get("cases"):
            took["per_1000_counted"] = 1000 * took["cpu_seconds"] / took["cases"]
        digits = {"cases": 0, "cpu_seconds": 1, "per_1000": 0, "per_1000_counted": 0}
        cells = (taken(took, name, each) for name, each in digits.items())
        lines.append(row(values["title"], _allowed(values), number(values["budget"]), *cells))
    heads = ("", "allowed", "runs a scene", "counted runs", "CPU s", "CPU s for 1000 scenes", "for 1000 counted runs")
    note = (
        "Each scene hands over one run. Planning, checking, driving, and judging until it is known which one are in it, reading "
        "the scenes is not."
    )
    return Table(
        f"attack-{driver}-costs", f"Table IV, extended. What cases of {driver} cost", heads, tuple(lines), (note,), False
    )


def _allowed(values: Mapping[str, Any]) -> str:
    return "-" if values["varies"] == "nothing" else str(values["allowed"])
