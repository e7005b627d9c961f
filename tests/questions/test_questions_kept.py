"""The question `goals-1` and that about corner cases stay as they were, byte for byte: recorded answers belong to them."""

import hashlib

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.corner_cases.asking import WORDING as CORNER
from drivegen.goals.candidates import candidates
from drivegen.lm.prompt import Image
from drivegen.questions.goals import Case, about_scenario, about_vehicle
from drivegen.questions.wordings import likeliest
from drivegen.roads.graph import LaneGraph
from tests import scenes
from tests.models import candidate_settings, two_lanes

KEPT = {
    "goals-1": "63931463d7a6d2c18408cf2dc5eca2d28617931fc5069b1f817043d78a143046",
    "corner-1": "5bab5432ec143bf14be049b2fbbc6cbb3a72b3d762d8bcf751531e272ba75eee",
}
"""SHA-256 of all their words and pictures about two scenes, by the code before `goals-2`."""


@pytest.mark.parametrize("wording", [likeliest("goals-1"), CORNER], ids=lambda wording: wording.version)
def test_the_older_questions_are_the_same_bytes(wording):
    prompts = []
    for scene in (scenes.busy_crossing(), two_lanes(14.0)):
        graph, settings = LaneGraph.of(scene.map), candidate_settings()
        found = [candidates(graph, scene, n, settings) for n in range(len(scene.vehicles))]
        cases = [Case.of(scene, n, c, 7, wording) for n, c in enumerate(found)]
        prompts += [about_vehicle(case, 5, 768, (), wording) for case in cases]
        prompts.append(about_scenario(cases, 5, 512, (), wording))
    told = hashlib.sha256()
    for prompt in prompts:
        for part in (prompt.version, prompt.instructions, *prompt.parts):
            told.update(part.content if isinstance(part, Image) else part.encode())
    assert told.hexdigest() == KEPT[wording.version]


def test_an_unknown_version_is_refused_with_those_that_there_are():
    with pytest.raises(UnusableInput, match=r"goals-1, goals-2, not 'goals-9'"):
        likeliest("goals-9")
