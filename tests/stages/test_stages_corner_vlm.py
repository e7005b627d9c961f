"""Corner cases whose goals a language model chooses, against a server of the tests."""

import json
from dataclasses import replace

import cv2
import numpy as np
import orjson
import pyarrow.parquet as pq
import pytest
import yaml

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.corner_cases.collisions import Collision, telling
from drivegen.corner_cases.knowledge import SHAPE, Knowledge
from drivegen.corner_cases.round_folder import RoundFolder
from drivegen.lm.ledger import FOLDER
from drivegen.lm.prompt import OverBudget
from drivegen.store.samples import read_samples
from drivegen.store.scenarios import write_shard
from stages import corner, goals
from stages._door import read_params
from tests.lm import asking
from tests.lm.chat_server import Says, serving
from tests.models import two_lanes
from tests.scenes import busy_crossing

SHARD = "shard-00000.parquet"
PARAMS = read_params("corner", corner.Params)


def says(*numbers):
    return Says(json.dumps({"ranking": [{"goal": n, "reason": "in its way"} for n in numbers]}))


@pytest.fixture(scope="module")
def root(tmp_path_factory, models):
    """Two scenes, their recorded goals, and round 0 with its params."""
    root = tmp_path_factory.mktemp("asked")
    write_shard(root / "test" / SHARD, [busy_crossing(101, "a"), two_lanes(9.0, "b")])
    goals.main(
        replace(read_params("goals", goals.Params), workers=1),
        root / "test",
        models / "selector",
        root / "learned",
        root / "g.parquet",
        root / "g.json",
    )
    corner.main(params_of(), root / "test", models, root / "learned", root / "0", root / "0.parquet", root / "0.json")
    return root


def params_of(**more):
    generation = replace(PARAMS.generation, rollout=replace(PARAMS.generation.rollout, attempts=2, rounds=3))
    brakeless = PARAMS.driver_settings | {"emergency_braking": 0.05, "braking": 0.05, "desired_speed": 20.0}
    params = replace(PARAMS, driver_settings=brakeless)  # so that these few scenes have collisions at all
    return replace(params, workers=2, samples=8, draws=20, prior_strength=1.0, generation=generation, **more)


@pytest.fixture
def round_one(root, models, tmp_path, monkeypatch):
    """Play round 1 with a model at a URL; returns its metrics, its bytes and what was used."""
    params = params_of(goals="vlm")
    monkeypatch.chdir(tmp_path)

    def play(url, mode, out, **role):
        settings = vars(asking.settings(url, **{"max_calls": 100, "max_tokens": 600, "prompt": "corner-1", **role}))
        lm = {"corner_cases": settings, "records": {"mode": mode, "folder": str(tmp_path / "store")}}
        (tmp_path / "params.yaml").write_text(yaml.safe_dump({"lm": lm}))
        (tmp_path / out).mkdir()
        (tmp_path / out / "0").symlink_to(root / "0")
        folder = tmp_path / out / "1"
        corner.main(
            params, root / "test", models, root / "learned", folder, tmp_path / f"{out}.parquet", tmp_path / f"{out}.json"
        )
        files = {f.relative_to(folder): f.read_bytes() for f in sorted(folder.rglob("*")) if f.is_file()}
        return orjson.loads((tmp_path / f"{out}.json").read_bytes()), files, read_samples(folder / "samples" / SHARD)

    return play


def test_a_round_leaves_pictures_of_collisions_with_words(root, tmp_path):
    assert RoundFolder(tmp_path / "0").shown() == ()  # one without collisions
    pictures = sorted(RoundFolder(root / "0").collisions.glob("*.png"))
    assert 0 < len(pictures) <= params_of().pictures
    for file in pictures:
        picture = cv2.imdecode(np.frombuffer(file.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
        assert picture.shape == (448, 448, 3)
        orange = (np.abs(picture.astype(int) - (20, 105, 234)) < 12).all(-1)
        assert orange[180:268, 180:268].sum() > 20  # the target is in the middle
        assert "collision of the target" in file.with_suffix(".txt").read_text()


def test_the_model_is_told_and_shown_what_the_round_before_found(root, round_one):
    with serving([says(0, 1)]) as server:
        metrics, _, samples = round_one(server.url, "auto", "first")
    known = Knowledge.from_json(orjson.loads((root / "0" / "knowledge.json").read_bytes()))
    shown = 1 + len(list(RoundFolder(root / "0").collisions.glob("*.png")))
    social = sum(s.used.shape[1] - 1 for s in samples)
    assert 0 < len(server.requests) <= social
    for request in server.requests:
        told = str(request["messages"])
        assert told.count("data:image/png;base64,") == shown
        riskiest = known.rows()[0]
        assert f"{riskiest['value']}".replace("_", " ") in told
        assert f"{riskiest['probability']:.3f} [{riskiest['low']:.3f}, {riskiest['high']:.3f}]" in told
        assert "most dangerous places" in told
        assert "<vehicle_0>" not in told  # the target's goal is its own
    assert metrics["goals"] == "language model little-model"
    assert metrics["asking"]["asked"] == len(server.requests)
    assert metrics["asking"]["vehicles"] == social
    calls = pq.read_table(next(FOLDER.glob("corner-1-*.parquet")))
    assert set(calls["role"].to_pylist()) == {"corner_cases"}
    assert calls.num_rows == len(server.requests)
    bound = params_of().pressure.max_ratio
    for s in samples:
        ratio = s.used[:, 1:] / s.natural[:, 1:]
        assert (ratio < bound * 1.01).all()
        assert (ratio > 0.99 / bound).all()
        np.testing.assert_allclose(s.used[:, 0], s.natural[:, 0], rtol=1e-5)


def test_a_recorded_round_is_replayed_to_the_same_bytes_with_nobody_called(round_one):
    with serving([says(2, 1)]) as server:
        with pytest.raises(MissingTool, match="corner-1"):
            round_one(server.url, "replay", "missing")
        assert not server.requests
        recorded = round_one(server.url, "record", "recorded")
        asked = len(server.requests)
        again = round_one(server.url, "replay", "again")
        assert len(server.requests) == asked
    assert again[:2] == recorded[:2]


def test_without_an_answer_the_re_weighting_counts_and_is_counted(root, models, round_one, tmp_path):
    (tmp_path / "plain").mkdir()
    (tmp_path / "plain" / "0").symlink_to(root / "0")
    corner.main(
        params_of(goals="reweighting"),
        root / "test",
        models,
        root / "learned",
        tmp_path / "plain" / "1",
        tmp_path / "p.parquet",
        tmp_path / "p.json",
    )
    plain = (tmp_path / "plain" / "1" / "samples" / SHARD).read_bytes()
    with serving([Says("no idea")]) as server:
        bad, files, _ = round_one(server.url, "auto", "bad")
        asked = bad["asking"]["fallback"]["invalid-answer"]
        assert len(server.requests) == 3 * asked > 0
    assert next(data for path, data in files.items() if path.parts[0] == "samples") == plain
    none, files, _ = round_one("", "replay", "none", backend="offline", model="")
    assert none["asking"]["fallback"] == {"no-model": asked}
    assert next(data for path, data in files.items() if path.parts[0] == "samples") == plain
    assert orjson.loads((tmp_path / "p.json").read_bytes())["goals"] == "statistical re-weighting"


def test_the_estimate_comes_before_the_first_call_and_the_budget_ends_the_round(round_one, tmp_path, capsys):
    with serving([says(0)]) as server:
        with pytest.raises(OverBudget):
            round_one(server.url, "auto", "dear", max_calls=2)
        assert len(server.requests) == 2
    told = capsys.readouterr().out
    assert "lm.corner_cases: language model little-model, one by one: about" in told
    assert "or 2 calls" in told
    assert pq.read_table(next(FOLDER.glob("corner-1-*.parquet"))).num_rows == 2  # what was spent is told all the same


def test_the_most_telling_collisions_differ_in_scene_and_if_they_can_in_features():
    seen, hit = np.full(SHAPE, 10), np.zeros(SHAPE, int)
    hit[1, 1, 1], hit[2, 2, 2] = 9, 5
    knowledge = Knowledge(seen, hit, 1.0)
    cells = [(2, 2, 2), (1, 1, 1), (1, 1, 1), (1, 1, 1)]
    found = [Collision(name, 0, 1, 50, 2, cell) for name, cell in zip(("d", "b", "a", "a"), cells, strict=True)]
    assert [c.scenario_id for c in telling(found, knowledge, 2)] == ["a", "d"]
    assert [c.scenario_id for c in telling(found, knowledge, 9)] == ["a", "d", "b"]


def test_who_leans_on_goals_is_one_of_two():
    with pytest.raises(UnusableInput, match="reweighting, vlm"):
        params_of(goals="llm")
