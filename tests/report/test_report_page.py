"""The page: complete whatever is missing, self-contained, the same for the same evidence."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from drivegen.core.methods import read_methods
from drivegen.render.png import png
from drivegen.report import Curve, Evidence, Link, Picture, all_sections, build_page
from drivegen.report.paper import MARK
from drivegen.report.section import Figure, Section
from drivegen.report.table import NOT_MEASURED, Table, row

DOT = png(np.zeros((2, 2, 3), np.uint8))


def quality(error: float, diversity: float) -> dict[str, float]:
    names = ("min_sade", "min_sfde", "mean_sade", "mean_sfde")
    values = dict(zip(names, (error, 2 * error, 2.5 * error, 4 * error), strict=True))
    values |= {f"diversity_ratio{end}": diversity for end in ("", "_plain", "_any_sample", "_any_sample_plain")}
    values |= {f"{what}_per_{of}": 0.0125 for what in ("collision", "off_road", "illegal") for of in ("vehicle", "scene")}
    values |= {"violation.red_light": 0.02, "realism": 0.8, "nll_3s": 2.5, "nll_joint_3s": 2.9, "boxes_90_collision": 0.01}
    values |= {"joint.order": 0.97, "shuffled.order": 0.95, "joint.energy_gain": 0.125}
    values |= {f"{name}.{end}": value for name, value in values.items() for end in ("low", "high")}
    return values | {"diversity_pairs": 1200, "label.road.junction": 3.0, "manoeuvre.left": 12.0}


FULL = Evidence(
    methods=read_methods(),
    results={
        "quality_details/log": quality(0.0, 1.0),
        "quality_details/constant_velocity": quality(3.0, 0.6),
        "quality_details/drivegen": quality(1.0, 0.9),
        "quality_details/drivegen_without_goals": quality(2.0, 1.3),
        "ingest": {"trained_on": "the corpus", "splits": {"train": {"corpus": {"accepted": 600, "rejected: truncated": 2}}}},
        "calibrate": {"limits": {"speed": 33.1}, "pass_rate": {"speed": 0.991, "legal": 0.96}, "share": 0.98},
        "train_selector": {"top_1": 0.62},
        "train_planner/route_fm": {"loss": 0.01},
        "goals/learned": {"described": "imitates logs", "moving": {"hit_1": 0.62}},
        "driving/idm": {
            "log.collision": 0.05,
            "log.collision.low": 0.01,
            "log.distance": 50.5,
            "log.recordings": 30.0,
            "drivegen.collision": 0.07,
        },
        "corner/1": {"collision": 0.05},
        "corner/2": {"collision": 0.15, "collision.low": 0.1, "collision.high": 0.2},
        "maps": {"roundabout": {"text": "a roundabout <script>", "valid": True}},
    },
    source="hand-made scenes",
    samples=4,
    scenes=(Picture("Scene <1>", "16 vehicles", DOT),),
    maps=(Picture("roundabout", "a roundabout", DOT),),
    curves=(Curve("train_planner/route_fm", {"step": [1.0, 2.0], "train": [1.0, 0.5], "validation": [1.1, float("nan")]}),),
    recordings=(Link("scene 1", "recordings/scene-1.rrd"),),
    provenance={"seed": "7"},
)


HELPS = {"quality_details": 4, "train_selector": 1}
"""Sections that a result fills, where it is not one."""


SECTIONS = all_sections(FULL)
TABLES = {table.name: table for section in SECTIONS for table in section.tables}


def page_of(evidence: Evidence) -> str:
    return build_page(all_sections(evidence), evidence.source)


class Reader(HTMLParser):
    """Collects what the page refers to and the text of its tables."""

    def __init__(self):
        super().__init__()
        self.refers, self.ids, self.open = [], [], []

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.refers += [values[name] for name in ("src", "href", "srcset", "data", "action") if name in values]
        self.ids += [values["id"]] if "id" in values else []
        if tag not in {"meta", "img", "link", "br"}:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    assert reader.open == []
    return reader


def test_the_page_loads_nothing_from_anywhere():
    page = build_page(SECTIONS, FULL.source)
    reader = read(page)
    assert all(re.match(r"data:image/|#|recordings/", place) for place in reader.refers)
    style = page[page.index("<style>") : page.index("</style>")]
    assert "url(" not in style
    assert "@import" not in style
    assert "<script" not in page


def test_every_table_stands_in_the_page_once():
    reader = read(build_page(SECTIONS, FULL.source))
    names = [table.name for section in SECTIONS for table in section.tables]
    assert len(names) == len(set(names))
    assert {f"table-{name}" for name in names} <= set(reader.ids)
    assert {"quality", "diversity", "safety", "corner-cases", "gpu-hours", "corner-rounds"} <= set(names)


def test_a_page_without_evidence_says_what_was_not_measured():
    page = page_of(Evidence())
    read(page)
    for stage in ("evaluate", "ingest", "corner", "train_planner", "maps", "record", "rollout", "drive", "calibrate"):
        assert f"the stage {stage} has not run" in page
    assert MARK in page


@pytest.mark.parametrize("only", sorted(FULL.results))
def test_any_part_may_be_there_alone(only):
    page = page_of(Evidence({only: FULL.results[only]}))
    read(page)
    assert page.count("has not run") == page_of(Evidence()).count("has not run") - HELPS.get(only.split("/")[0], 1)


def test_the_same_evidence_is_the_same_page():
    assert page_of(FULL) == build_page(SECTIONS, FULL.source)


def test_the_paper_s_rows_are_marked_and_ours_name_their_data():
    table = TABLES["quality"]
    by_origin = {origin: [row for row in table.rows if row.origin == origin] for origin in ("ours", "paper")}
    assert {row.cells[1].text for row in by_origin["paper"]} == {MARK}
    assert {row.cells[1].text for row in by_origin["ours"] if row.cells[3].text != NOT_MEASURED} == {FULL.source}
    paper_drivegen = [cell.text for cell in by_origin["paper"][-1].cells]
    assert paper_drivegen == ["DriveGen", MARK, "", "1.18", "2.16", "2.59", "3.64", "0.93"]


def test_the_best_generator_is_bold_and_the_log_never():
    table = TABLES["quality"]
    bold = {row.cells[0].text for row in table.rows for cell in row.cells if cell.best}
    assert bold == {"DriveGen"}


def test_methods_that_did_not_run_are_rows_and_goals_have_a_chooser():
    lines = {
        row.cells[0].text: [cell.text for cell in row.cells[1:4]]
        for row in TABLES["quality"].rows
        if row.origin in ("ours", "rival")
    }
    assert lines["BITS"] == [NOT_MEASURED, "\u2013", NOT_MEASURED]
    assert lines["DriveGen"][1] == "imitates logs"
    assert lines["DriveGen w/o gs"][1] == "random"
    assert {"SceneTransformer", "TrafficGen", "LCTGen", "IDM"} <= set(lines)


def test_a_rival_that_does_not_beat_constant_velocity_is_marked():
    results = {"quality_details/constant_velocity": quality(3.0, 0.6), "quality_details/bits": quality(3.0, 0.7)}
    results["quality_details/lctgen"] = quality(2.9, 0.7)
    tables = {table.name: table for section in all_sections(Evidence(results, methods=FULL.methods)) for table in section.tables}
    for name in ("quality", "scores", "safety"):
        names = {row.cells[0].text for row in tables[name].rows if row.origin != "paper"}
        assert {"BITS, under-trained", "LCTGen"} <= names


def test_trust_measures_stand_beside_one_another():
    scores, realism, boxes = TABLES["scores"], TABLES["realism"], TABLES["boxes"]
    assert "NLL of the scene at 3 s \u2193" in scores.columns
    by_name = {row.cells[0].text: row for row in realism.rows}
    assert (by_name["DriveGen"].cells[1].text, by_name["DriveGen"].cells[1].note) == ("0.80", "")  # both ends are the value
    assert by_name["BITS"].cells[1].text == NOT_MEASURED
    assert boxes.columns[1:4] == ("boxes x 0.9", "boxes x 1.0", "boxes x 1.1")
    assert any("divided by 0.95" in note for note in realism.notes)


def test_samples_stand_beside_themselves_shuffled():
    table = TABLES["joint"]
    by_name = {row.cells[0].text: [cell.text for cell in row.cells] for row in table.rows}
    order = table.columns.index("in the log's order \u2191")
    assert table.columns[order + 1] == "shuffled"
    assert by_name["DriveGen"][order : order + 2] == ["0.970", "0.950"]
    assert by_name["DriveGen"][table.columns.index("shuffled: more by")] == "0.125"
    assert set(by_name["BITS"][1:]) == {NOT_MEASURED}


def test_markup_in_names_and_texts_is_text():
    page = build_page(SECTIONS, FULL.source)
    assert "Scene &lt;1&gt;" in page
    assert "a roundabout &lt;script&gt;" in page


def test_sections_have_one_anchor_each():
    anchors = [section.anchor for section in SECTIONS]
    assert len(anchors) == len(set(anchors))
    assert set(anchors) <= set(read(build_page(SECTIONS, FULL.source)).ids)


def test_tables_say_what_models_were_trained_on():
    note = "argoverse2 has 5 usable training tracks, fewer than 200: not trained on"
    results = {**FULL.results, "ingest": {"trained_on": "SUMO corpus (simulated)", "note": note}}
    sections = all_sections(Evidence(results, methods=FULL.methods))
    wanted = f"Models were trained on: SUMO corpus (simulated). {note}."
    carry = {table.name for section in sections for table in section.tables if wanted in table.notes}
    assert {"quality", "diversity", "safety", "violations", "corner-cases", "summary"} <= carry


def test_ours_and_rivals_look_different():
    looks = {row.cells[0].text: row.origin for row in TABLES["quality"].rows if row.origin != "paper"}
    assert (looks["DriveGen"], looks["DriveGen w/o gs"], looks["BITS"]) == ("ours", "ours", "rival")


def test_long_tables_are_folded_and_pictures_come_first():
    long = Table("long", "Long", ("",), tuple(row(str(n)) for n in range(13)))
    figure = Figure.svg("Plot", "", b"<svg/>")
    page = build_page([Section("one", "One", "", (long,), (figure,))], "")
    assert "<summary>Long <small>13 rows</small></summary>" in page
    assert page.index("<figure") < page.index("<details")
    assert "<details" not in build_page([Section("one", "One", "", (replace(long, rows=long.rows[:12]),))], "")


def test_the_driver_in_logs_is_the_dataset_s_row_of_table_three():
    (ours,) = (row for row in TABLES["corner-cases"].rows if row.cells[0].text == "Dataset, ours")
    assert [cell.text for cell in ours.cells[2:5]] == ["0.05", "50.50", "not measured"]
    assert not [name for name in TABLES["corner-cases"].columns if name.startswith(("GAIL", "SAC"))], "nobody drove them"
    assert [row.cells[0].text for row in TABLES["driving-idm"].rows] == ["DriveGen", "Log (recorded futures)"]
    assert TABLES["driving-idm"].notes[-1] == "Intervals (95 %) are over 30 recordings."


def test_limits_are_listed_by_rule():
    table = TABLES["checker"]
    assert table.columns == ("rule", "limits", "pass rate")
    assert [[cell.text for cell in row.cells] for row in table.rows] == [["speed", "33.100", "0.991"]]
    assert [[cell.text for cell in row.cells] for row in TABLES["checker-verdicts"].rows] == [["legal", "0.960"]]
    assert "98 % of logged tracks pass each of them" in build_page(SECTIONS, FULL.source)


def test_round_ten_comes_after_round_nine_and_the_last_one_stands_beside_the_paper():
    rounds = {f"corner/{number}": {"collision": number / 100} for number in (0, 9, 10)}
    costs = {f"corner/{number}": {"cpu_seconds": 36.0 * number, "runs": 10.0} for number in (9, 10)}
    evidence = Evidence(rounds, methods=FULL.methods, costs=costs)
    tables = {table.name: table for section in all_sections(evidence) for table in section.tables}
    assert [row.cells[0].text for row in tables["corner-rounds"].rows] == ["0", "9", "10"]
    ours = next(row for row in tables["corner-cases"].rows if row.cells[0].text == "DriveGen-CS, ours")
    assert ours.cells[2].text == "0.10"
    assert tables["gpu-hours"].rows[0].cells[-1].text == "10"


@pytest.mark.parametrize(("driver", "column"), [("sac", "SAC CR"), ("late", None)])
def test_rounds_of_another_driver_do_not_stand_under_idm(driver, column):
    rounds = {"corner/0": {"collision": 0.3, "driver": driver}}
    tables = {table.name: table for section in all_sections(Evidence(rounds)) for table in section.tables}
    ours = [row for row in tables["corner-cases"].rows if row.cells[0].text == "DriveGen-CS, ours"]
    assert [tables["corner-cases"].columns[2]] == ([column] if column else ["IDM CR"])
    assert [row.cells[2].text for row in ours] == (["0.30"] if column else [])


def test_a_round_says_in_words_what_made_the_driver_fail():
    cell = {"feature": "behaviour", "value": "turning_left", "encounters": 9, "collisions": 2}
    rounds = {"corner/1": {"collision": 0.1, "knowledge": [cell | {"probability": 0.2, "low": 0.05, "high": 0.5}]}}
    tables = {table.name: table for section in all_sections(Evidence(rounds, methods=FULL.methods)) for table in section.tables}
    (row,) = tables["corner-1-knowledge"].rows
    assert [c.text for c in row.cells] == ["behaviour", "turning left", "9", "2", "0.200"]
    assert row.cells[-1].note == "0.050\u20130.500"


@pytest.mark.parametrize(
    ("samples", "said"), [(4, ">4 samples of every test scenario"), (None, ">Samples of every test scenario")]
)
def test_the_page_says_how_many_samples_there_are_if_it_is_known(samples: int | None, said: str):
    page = build_page(all_sections(replace(FULL, samples=samples)), FULL.source)
    assert said in page
