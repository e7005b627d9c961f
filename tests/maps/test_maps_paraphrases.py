"""What is said in many ways must mean the same road: descriptions of many voices, each with what the network must have.

A line of `paraphrases.jsonl` is {"text", "expect"}, names of `Structure` as in the suite, or null where it must be refused.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from drivegen.errors import UnusableInput
from drivegen.maps.checks import failures
from drivegen.maps.examine import examine
from drivegen.maps.suite.cases import Case
from drivegen.maps.writers.offline import Plugin

ROWS = [json.loads(line) for line in (Path(__file__).parent / "paraphrases.jsonl").read_text(encoding="utf-8").splitlines()]


@pytest.mark.parametrize("row", [row for row in ROWS if row["expect"] is not None], ids=lambda row: row["text"][:60])
def test_a_paraphrase_becomes_the_road_that_it_describes(row: dict[str, Any]) -> None:
    found = examine(Plugin().write(row["text"], 7).spec)
    assert failures(list(found.checks)) == []
    assert Case("paraphrases", "", row["text"], row["expect"]).wrong(found.network, found.structure) == []


@pytest.mark.parametrize("row", [row for row in ROWS if row["expect"] is None], ids=lambda row: repr(row["text"][:60]))
def test_what_is_no_road_is_refused(row: dict[str, Any]) -> None:
    with pytest.raises(UnusableInput):
        Plugin().write(row["text"], 7)
