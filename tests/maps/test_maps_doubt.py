"""When the rules abstain, ask the described examples, or answer by likeness."""

from collections import Counter
from pathlib import Path

import pytest

from drivegen.errors import UnusableInput
from drivegen.maps.build import build_map
from drivegen.maps.spec import MapSpec
from drivegen.maps.writers import _likeness
from drivegen.maps.writers._likeness import MARGIN, TYPICAL, Index, examples, kind_of, nearest
from drivegen.maps.writers.offline import Plugin


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a signalised crossing with two lanes per direction of 4 arms and 9 branches", "9 branches"),
        ("a side road and a traffic light", "meet"),
        ("a motorway with a stop sign", "stop sign"),
        ("a crossing without any roads", "denied"),
        ("<edge id='a' numLanes='3'/> crossing", "markup"),
    ],
)
def test_what_does_not_fit_the_road_is_named_and_refused(text: str, word: str) -> None:
    with pytest.raises(UnusableInput, match=word):
        Plugin().write(text, 7)


@pytest.mark.parametrize("kind", TYPICAL)
def test_the_rules_draw_every_kind_that_likeness_may_answer(kind: str) -> None:
    spec = Plugin().write(TYPICAL[kind], 7).spec
    assert isinstance(spec, MapSpec)
    assert kind_of(spec.road.model_dump()) == kind


def test_likeness_answers_only_above_its_margin_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivegen.maps.writers.offline.road", without_the_first())
    monkeypatch.setattr("drivegen.maps.writers.offline.nearest", lambda text: _likeness.Nearest("t", "some tee", 0.9, MARGIN))
    built = build_map("two lanes, 40 km/h, traffic lights", 7)
    assert built.structure.arms == (3,)
    assert built.structure.signals == 1
    assert built.structure.speed == pytest.approx(40 / 3.6, rel=0.01)
    assert "likeness" in built.account["backend"]
    assert "some tee" in built.account["understood"][-1]["meaning"]
    monkeypatch.setattr("drivegen.maps.writers.offline.road", without_the_first())
    below = _likeness.Nearest("t", "some tee", 0.9, MARGIN - 0.01)
    monkeypatch.setattr("drivegen.maps.writers.offline.nearest", lambda text: below)
    with pytest.raises(UnusableInput, match="no road that I know"):
        Plugin().write("two lanes, 40 km/h, traffic lights", 7)


def without_the_first():  # type: ignore[no-untyped-def]
    """The rules' last step, which finds no road the first time that it is asked."""
    from drivegen.maps.writers._roads import road

    asked: list[object] = []

    def later(facts, choices):  # type: ignore[no-untyped-def]
        asked.append(facts)
        return road(facts, choices) if len(asked) > 1 else None

    return later


def test_the_published_margin_is_the_measured_one() -> None:
    """Each example against the others, its own paraphrases (cosine 0.8 and more) left out; docs/maps.md states the figure."""
    index, found = Index(examples()), Counter[str]()
    for i, example in enumerate(examples()):
        cosines = [-1.0 if j == i or c >= 0.8 else c for j, c in enumerate(index.likeness(example.text))]
        near = index.nearest_among(cosines)
        answers = near.margin >= MARGIN and near.kind in TYPICAL
        found["abstained" if not answers else "right" if near.kind == example.kind else "wrong"] += 1
    assert found["right"] >= 8 * found["wrong"]
    assert found["right"] >= 15
    stated = f"{found['right']} right, {found['wrong']} wrong, {found['abstained']} abstained"
    assert stated in (Path(__file__).parents[2] / "docs" / "maps.md").read_text(encoding="utf-8")


def test_nothing_like_an_example_is_near_none() -> None:
    assert nearest("xylophone quartet").margin == 0.0
