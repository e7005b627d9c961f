"""The section on the safety of generated traffic."""

from drivegen.core.methods import read_methods
from drivegen.report.evidence import Evidence
from drivegen.report.sections.quality import safety
from drivegen.report.table import NOT_MEASURED


def test_shares_are_told_in_per_cent_with_their_interval():
    values = {"collision_per_vehicle": 0.1, "collision_per_vehicle.low": 0.05, "collision_per_vehicle.high": 0.2}
    table = safety(Evidence(methods=read_methods(), results={"quality_details/bits": values})).tables[0]
    (row,) = table.rows
    assert (row.cells[1].text, row.cells[1].note) == ("10.0 %", "5.0\u201320.0")
    assert {cell.text for cell in row.cells[2:]} == {NOT_MEASURED}
