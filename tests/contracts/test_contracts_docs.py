"""The README is short, and what it and the documents link to is there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"\]\(([^)#]+)")
FILES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "reports/published/README.md"]


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(ROOT)))
def test_every_link_leads_to_a_file(file):
    links = [link for link in LINK.findall(file.read_text()) if "://" not in link]
    assert not [link for link in links if not (file.parent / link).exists()]


def test_every_document_is_linked_from_the_readme():
    links = set(LINK.findall((ROOT / "README.md").read_text()))
    assert {f"docs/{file.name}" for file in (ROOT / "docs").glob("*.md")} <= links


def test_the_readme_is_read_in_five_minutes():
    words = (ROOT / "README.md").read_text().split()
    assert len(words) <= 1200
    assert "![" in " ".join(words[:150]), "a picture comes first"
