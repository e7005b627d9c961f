"""The section on vehicles: first frames beside those of logs, bounds said to be bounds."""

from drivegen.report.evidence import Evidence
from drivegen.report.sections.vehicles import section


def told(name: str, value: float) -> dict[str, object]:
    names = ("speed", "gap", "heading", "offset", "overlap", "off_lane")
    ends = {"": value, ".low": value / 2, ".high": 2 * value}
    return {"name": name, "placed": 9, "asked": 10, **{f"{name}{end}": number for name in names for end, number in ends.items()}}


def test_first_frames_stand_in_a_table_of_their_own():
    counted = ("name", "placed", "asked", "overlap", "off_lane")
    truth = {key: value for key, value in told("held-out logs", 0.0).items() if key.split(".")[0] in counted}
    methods = [truth, *(told(name, value) for name, value in (("DriveGen, mode data", 0.3), ("TrafficGen", 0.25)))]
    found = section(Evidence(results={"initial_states": {"scenes": 3, "recordings": 2, "methods": methods}}))
    (table,) = found.tables
    assert [line.cells[0].text for line in table.rows] == ["held-out logs", "DriveGen, mode data", "TrafficGen"]
    assert [cell.text for cell in table.rows[0].cells[1:]] == ["9 of 10", "–", "–", "–", "–", "0.0 %", "0.0 %"]
    assert (table.rows[2].cells[2].text, table.rows[2].cells[2].note) == ("0.25", "0.12–0.50")
    assert table.rows[2].cells[-1].text == "25.0 %"
    assert not any(cell.best for line in table.rows for cell in line.cells)
    assert not found.missing
    assert "over 2 recordings, which are few" in table.notes[0]


def test_one_recording_is_said_to_give_no_intervals():
    (table,) = section(Evidence(results={"initial_states": {"scenes": 3, "recordings": 1, "methods": []}})).tables
    assert "One recording gives no intervals." in table.notes[0]


def test_nothing_measured_is_said():
    assert section(Evidence()).missing
