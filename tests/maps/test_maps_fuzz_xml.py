"""Mutated XML and replies of language models: a map that was checked, or one of our own errors; see `test_maps_fuzz.py`."""

import contextlib
import json
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivegen.core import seeds
from drivegen.core.errors import DriveGenError, UnusableInput
from drivegen.layouts.compile import draw
from drivegen.layouts.spec import MapSpec
from drivegen.lm.prompt import NoAnswer, Prompt
from drivegen.lm.reading import InvalidReply, read
from drivegen.maps.examine import WrittenNetwork, examine
from drivegen.maps.plain_xml import MOST_PROBLEMS, UnusableXml, read_plain
from drivegen.maps.writers import language_model, language_model_xml
from drivegen.maps.writers._examples import EXAMPLES
from drivegen.maps.writers.language_model_xml import _shown
from drivegen.sumo.plain import PlainNetwork
from tests.maps.mutants import COUNT, at_most, mutated_bytes, mutated_numbers, mutated_spec
from tests.maps.test_maps_fuzz import strayed as strayed

TEXT = "a signalised crossroads"


def files() -> list[list[str]]:
    """Nodes, edges and connections of worked examples."""
    roads = [dict(EXAMPLES)[text] for text, _ in EXAMPLES if _shown(text)]
    return [[file.decode() for file in draw(MapSpec.model_validate({"road": road})).files().values()] for road in roads]


class Parrot:
    """Stands in for a language model: says one thing whatever it is asked, through the real reader of replies."""

    prompt_version = "roads-3"
    description = "parrot"

    def __init__(self, reply: str) -> None:
        self._reply = reply

    def ask(self, prompt: Prompt[Any], sample: int = 0) -> Any:
        try:
            return read(self._reply, prompt)
        except InvalidReply as wrong:
            raise NoAnswer(str(wrong), "invalid-answer") from None


def read_or_refused(*texts: str) -> PlainNetwork | None:
    """The network, or None where the reader says in a few printable lines what is wrong."""
    problems: tuple[str, ...] = ()
    try:
        return read_plain(*texts)
    except UnusableXml as error:
        problems = error.problems
    assert 1 <= len(problems) <= MOST_PROBLEMS
    assert all(line.isprintable() for line in problems)
    return None


def test_mutated_xml_is_built_or_refused_line_by_line(strayed: list[str]) -> None:
    rng = seeds.rng(7, "fuzz", "xml")
    bases = files()
    built = refused = 0
    for i in range(2 * COUNT):
        texts = list(bases[i % len(bases)])
        place = int(rng.integers(3))
        if rng.random() < 0.5 and '="' in texts[place]:
            texts[place] = mutated_numbers(rng, texts[place])
        else:
            texts[place] = mutated_bytes(rng, texts[place].encode()).decode("utf-8", "replace")
        with at_most(), contextlib.suppress(UnusableInput):
            if (network := read_or_refused(*texts)) is None:
                refused += 1
            else:
                built += len(examine(WrittenNetwork(network)).network) > 0
    assert refused > COUNT // 2
    assert built > 0


def test_mutated_replies_become_checked_maps_or_are_refused(strayed: list[str]) -> None:
    rng = seeds.rng(7, "fuzz", "replies")
    names = ("nodes", "edges", "connections")
    drawn = [{**dict(zip(names, texts, strict=True)), "asked": {"lanes": 1}} for texts in files()]
    typed = [{"map": {"road": json.loads(json.dumps(road))}, "assumed": ["50 km/h"]} for _, road in EXAMPLES]
    plugins = ((language_model.Plugin, typed), (language_model_xml.Plugin, drawn))
    heard = 0
    for i in range(2 * COUNT):
        plugin, bases = plugins[i % 2]
        answer = mutated_spec(rng, bases[i // 2 % len(bases)]) if rng.random() < 0.8 else bases[i // 2 % len(bases)]
        reply = json.dumps(answer)
        if rng.random() < 0.3:
            reply = mutated_bytes(rng, reply.encode()).decode("utf-8", "replace")
        with at_most(), contextlib.suppress(DriveGenError):
            understanding = plugin(Parrot(reply)).write(TEXT, 7)
            assert understanding.writer.startswith("parrot")
            heard += understanding.writer.startswith("parrot")
    assert heard > 0


_NAMES = st.sampled_from(["a", "b", "ab", "ba", "-ab", "", "../x", "&amp;", "\u202e", "x" * 40])
_VALUES = st.one_of(_NAMES, st.integers(-2, 9).map(str), st.floats(width=16).map(str), st.text(max_size=6).map(json.dumps))
_ATTRIBUTES = st.sampled_from(
    ["id", "x", "y", "from", "to", "numLanes", "speed", "shape", "fromLane", "toLane", "type", "radius"]
)


@st.composite
def xml(draw: st.DrawFn, tag: str, child: str) -> str:
    """Files that look like plain XML and mostly are none."""
    rows = draw(st.lists(st.dictionaries(_ATTRIBUTES, _VALUES, max_size=6), max_size=4))
    inner = "".join(f"<{child} " + " ".join(f'{k}="{v}"' for k, v in row.items()) + "/>" for row in rows)
    return f"<{tag}>{inner}</{tag}>" if draw(st.booleans()) else draw(st.text(max_size=30)) + inner


@settings(max_examples=COUNT, deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True)
@given(xml("nodes", "node"), xml("edges", "edge"), xml("connections", "connection"))
def test_no_text_breaks_the_reader(nodes: str, edges: str, connections: str) -> None:
    network = read_or_refused(nodes, edges, connections)
    assert network is None or (network.nodes and network.edges)
