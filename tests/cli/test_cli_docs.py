"""Every command of the README and the docs is one that the command line knows, with the options that stand there."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from drivegen.cli import COMMANDS, build

ROOT = Path(__file__).parents[2]
LINE = re.compile(r"^(?:\.venv/bin/)?drivegen (.*)$", re.MULTILINE)


def commands() -> list[list[str]]:
    """The words of each command in a block of code, comments cut off."""
    found = []
    for file in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        for block in re.findall(r"^```\w*\n(.*?)^```", file.read_text(), re.DOTALL | re.MULTILINE):
            found += [shlex.split(words, comments=True) for words in LINE.findall(block)]
    return found


def subcommand(words: list[str]) -> list[str]:
    if words[0] == "map":
        return words[:2] if words[1] in ("import", "refine", "export") else ["map", "words"]
    return words[:2] if words[:2] == ["bench", "maps"] else words[:1]


def test_there_are_commands_in_the_docs():
    assert {words[0] for words in commands()} == set(COMMANDS)


@pytest.mark.parametrize("words", commands(), ids=" ".join)
def test_a_command_of_the_docs_has_its_options(words):
    asked = subcommand(words)
    done = CliRunner().invoke(build(asked), [*asked, "--help"], catch_exceptions=False)
    assert done.exit_code == 0
    known = set(re.findall(r"--[a-z-]+", done.output))
    assert {word for word in words if word.startswith("--")} <= known


def test_no_more_is_promised_of_a_seed_than_is_so():
    done = CliRunner().invoke(build(["generate"]), ["generate", "--help"], catch_exceptions=False)
    assert "of recordings (.rrd) the same content" in " ".join(done.output.replace("│", " ").split())
