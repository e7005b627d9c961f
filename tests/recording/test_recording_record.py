"""Recordings, read back from their files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from drivegen.core.errors import UnusableInput
from drivegen.core.samples import Violation
from drivegen.core.scenario import TARGET, Actors, Trajectories, VehicleKind
from drivegen.core.signals import Signals, SignalState
from drivegen.recording import GoalMarks, record_scenario
from drivegen.recording.collision import record_collision
from drivegen.recording.compare import record_comparison
from drivegen.recording.drivers import record_drivers
from drivegen.recording.roads import surroundings
from drivegen.recording.traffic import FREE, clearance
from drivegen.store.collisions import Where
from tests.scenes import busy_crossing, drive, noisy_samples, road_map, scenario, stack, straight_road


def read(path: Path) -> dict[str, dict[str, list]]:
    """Entity -> component column -> rows, and under "" the time lines."""
    found: dict[str, dict[str, list]] = {}
    for chunk in rr.chunk.RrdReader(path).stream():
        entity = found.setdefault(chunk.entity_path, {})
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if ":" in name:
                entity.setdefault(name, []).extend(batch.column(name).to_pylist())
        if "step" in batch.schema.names:
            for name in batch.schema.names:
                rows = entity.setdefault(f"step of {name}", []) if ":" in name else []
                rows.extend(batch.column("step").to_pylist())
        entity.setdefault("times", []).extend(chunk.timeline_names)
        entity.setdefault("static", []).append(chunk.is_static)
    for entity in found.values():
        entity["static"].sort()  # chunks come in any order
    return found


def at_steps(entity: dict[str, list], component: str) -> dict[int, list]:
    """The rows of a component by the step from which on they hold."""
    return dict(zip(entity[f"step of {component}"], entity[component], strict=True))


def contrast(one: int, other: int) -> float:
    """Of two colours 0xRRGGBBAA, the first with its alpha on the second: 1 for alike, 21 for black on white (WCAG 2.1)."""
    alpha = (one & 255) / 255
    bytes_of = [[(colour >> shift & 255) / 255 for shift in (24, 16, 8)] for colour in (one, other)]
    seen = [alpha * a + (1 - alpha) * b for a, b in zip(*bytes_of, strict=True)]
    dark, light = sorted(
        sum(w * _linear(c) for w, c in zip((0.2126, 0.7152, 0.0722), rgb, strict=True)) for rgb in (seen, bytes_of[1])
    )
    return (light + 0.05) / (dark + 0.05)


def _linear(channel: float) -> float:
    return channel / 12.92 if channel <= 0.04045 else ((channel + 0.055) / 1.055) ** 2.4


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    scene = busy_crossing()
    goals = GoalMarks(
        position=np.concatenate([scene.log.position[:, -1], scene.log.position[:2, -1] + 5]),
        vehicle=np.arange(10, dtype=np.int32) % 8,
        number=np.arange(10, dtype=np.int32),
        probability=np.full(10, 0.25, np.float32),
        leaves_after=np.where(np.arange(10) == 1, 6.24, np.inf).astype(np.float32),
        chosen=np.arange(10) < 8,
    )
    path = tmp_path_factory.mktemp("recording") / "scene.rrd"
    image = np.zeros((64, 64, 3), np.uint8)
    record_scenario(path, scene, noisy_samples(scene), sample=0, goals=goals, bird_eye=image)
    return path, read(path)


def test_everything_that_a_viewer_should_see_is_there(recorded):
    _, found = recorded
    wanted = {"/bird_eye", "/verdicts", "/world/signals", "/world/paths", "/world/logged"}
    wanted |= {f"/world/roads/{what}" for what in ("surface", "boundaries", "connections", "drivable", "stop_lines")}
    wanted |= {"/world/traffic/target", "/world/traffic/social", "/world/goals/candidates", "/world/goals/chosen"}
    wanted |= {f"/plots/{kind}/{of}" for kind in ("speed", "clearance") for of in ("generated", "logged")}
    assert wanted <= set(found)


def test_vehicles_move_over_both_time_lines(recorded):
    _, found = recorded
    social = found["/world/traffic/social"]
    assert {"time", "step"} <= set(social["times"])
    centres = [row for row in social["Boxes3D:centers"] if row is not None]
    assert len(centres) == 101
    assert {len(row) for row in centres} == {7}
    moved = (
        np.array(found["/world/traffic/target"]["Boxes3D:centers"][-1][0])
        - found["/world/traffic/target"]["Boxes3D:centers"][0][0]
    )
    assert np.hypot(moved[0], moved[1]) > 50


def test_boxes_turn_red_at_their_first_violation(recorded):
    _, found = recorded
    shown = at_steps(found["/world/traffic/target"], "Boxes3D:colors")
    assert list(shown) == [0, 40]  # what does not change is not repeated
    assert shown[0] != shown[40]


def test_verdicts_say_who_what_and_when(recorded):
    _, found = recorded
    lines = [row[0] for row in found["/verdicts"]["TextLog:text"]]
    assert len(lines) == 8
    assert "target: collision from step 40" in lines
    assert "vehicle track-5: legal" in lines


def test_signals_are_logged_once_while_nothing_changes(recorded):
    _, found = recorded
    assert len([row for row in found["/world/signals"]["LineStrips3D:colors"] if row is not None]) == 1


def test_chosen_goals_carry_number_and_probability(recorded):
    _, found = recorded
    assert found["/world/goals/target"]["Points3D:labels"][0] == ["0: 25%"]
    assert found["/world/goals/chosen"]["Points3D:labels"][0][0] == "1: 25%, leaves the map after 6.2 s"


def test_only_the_target_s_goal_is_labelled_unasked(recorded):
    _, found = recorded
    shown = {name: found[f"/world/goals/{name}"]["Points3D:show_labels"][0] for name in ("target", "chosen")}
    assert shown == {"target": [True], "chosen": [False]}


def test_a_legend_names_what_is_shown(recorded):
    _, found = recorded
    [text] = found["/legend"]["TextDocument:text"][0]
    assert "move as generated" in text
    assert "**White frames**: logged" in text


def test_the_legend_of_a_scene_without_log_says_what_red_is(tmp_path):
    scene = busy_crossing()
    record_scenario(tmp_path / "x.rrd", replace(scene, log=None), noisy_samples(scene))
    [text] = read(tmp_path / "x.rrd")["/legend"]["TextDocument:text"][0]
    assert "red from the first fault on" in text
    assert "Violet" in text
    assert "White frames" not in text


def test_a_collision_marks_the_impact_and_says_who_drove(tmp_path):
    scene = busy_crossing()
    samples = noisy_samples(scene)
    driven = samples.motion[:, TARGET]
    driven.valid[0, 31:] = False
    where = Where(scene.scenario_id, "shard-0.parquet", 0, 3, 30)
    record_collision(tmp_path / "hit.rrd", scene, samples, driven, where, "Round 2, collision 1", "it came from the left")
    found = read(tmp_path / "hit.rrd")
    ball = found["/world/impact"]
    assert ball["Points3D:labels"] == [["impact, 3.0 s"]]
    assert ball["step of Points3D:positions"] == [30]
    assert {f"/plots/speed/{name}" for name in ("driven", "planned")} <= set(found)
    assert "/plots/speed/logged" not in found
    for name in ("driven", "planned"):
        line = found[f"/plots/speed/{name}"]["SeriesLines:colors"][0][0]
        for ground in (0xFFFFFFFF, 0x11141AFF):  # of the viewer's light theme, and the scene's own
            assert contrast(line, ground) > 2, name
    assert "it came from the left" in found["/legend"]["TextDocument:text"][0][0]
    boxes = [row for row in found["/world/traffic"]["Boxes3D:centers"] if row is not None]
    assert len(boxes[30]) == len(boxes[31]) + 1  # the driven target is gone after the impact


def test_a_collision_with_a_person_has_nobody_red(tmp_path):
    scene = busy_crossing()
    size = np.float32([[0.5, 0.5, 1.8]])
    scene = replace(scene, context=Actors(np.array(["walker"]), np.uint8([VehicleKind.PEDESTRIAN]), size, scene.log[3:4]))
    samples = noisy_samples(scene)
    for name, partner in (("car", 3), ("person", len(scene.vehicles))):
        where = Where(scene.scenario_id, "", 0, partner, 30)
        record_collision(tmp_path / f"{name}.rrd", scene, samples, samples.motion[:, TARGET], where, "hit", "")
    legends = {name: read(tmp_path / f"{name}.rrd")["/legend"]["TextDocument:text"][0][0] for name in ("car", "person")}
    assert "**Red**" in legends["car"]
    assert "**Red**" not in legends["person"]
    assert "**Green**: people and cyclists, one of whom it met" in legends["person"]


def test_drivers_share_a_scene_and_those_that_collide_are_marked(tmp_path):
    scene = busy_crossing()
    careful, hasty = noisy_samples(scene).motion[:2, TARGET]
    hasty.valid[41:] = False
    record_drivers(tmp_path / "all.rrd", scene, {"careful": careful, "hasty": hasty}, ["hasty"])
    found = read(tmp_path / "all.rrd")
    assert {f"/plots/speed/{name}" for name in ("logged", "careful", "hasty")} <= set(found)
    assert found["/world/impacts/hasty"]["Points3D:labels"] == [["hasty, 4.0 s"]]
    assert found["/world/impacts/hasty"]["step of Points3D:positions"] == [40]
    assert "/world/impacts/careful" not in found
    legend = found["/legend"]["TextDocument:text"][0][0]
    assert "* careful: no collision" in legend
    assert "* hasty: collision" in legend
    shades = [found[f"/world/drivers/{name}"]["Boxes3D:colors"][0] for name in ("careful", "hasty")]
    assert shades[0] != shades[1]
    with pytest.raises(UnusableInput, match="has no log to drive through"):
        record_drivers(tmp_path / "none.rrd", replace(scene, log=None), {}, [])
    assert not (tmp_path / "none.rrd").exists()


def test_the_layout_is_inside_and_the_file_is_light(recorded):
    path, _ = recorded
    assert len(list(rr.chunk.RrdReader(path).blueprints())) == 1
    assert path.stat().st_size < 300_000
    assert [file.name for file in path.parent.iterdir()] == ["scene.rrd"]


def test_the_viewer_keeps_files_of_one_name_apart(tmp_path):
    paths = [tmp_path / kind / "recording.rrd" for kind in ("cut-in", "standing")]
    for path in paths:
        record_scenario(path, busy_crossing())
    identities = {one.recording_id for path in paths for one in rr.chunk.RrdReader(path).recordings()}
    assert len(identities) == 2


def test_two_recordings_of_one_scene_have_the_same_content(recorded, tmp_path):
    scene = busy_crossing()
    for name in ("one", "two"):
        record_scenario(tmp_path / name, scene)
    assert read(tmp_path / "one") == read(tmp_path / "two")


def test_a_log_alone_has_no_ghosts_and_no_verdicts(tmp_path):
    record_scenario(tmp_path / "log.rrd", busy_crossing())
    found = read(tmp_path / "log.rrd")
    assert not {"/world/logged", "/verdicts", "/bird_eye"} & set(found)
    assert "/plots/speed/logged" in found


def test_a_vehicle_that_was_not_seen_is_not_drawn(tmp_path):
    scene = busy_crossing(steps=20)
    scene.log.valid[3, 5:] = False
    record_scenario(tmp_path / "gap.rrd", scene)
    social = read(tmp_path / "gap.rrd")["/world/traffic/social"]
    assert [len(row) for row in at_steps(social, "Boxes3D:centers").values()] == [7] * 5 + [6] * 15
    for component in ("half_sizes", "colors", "labels"):
        rows = at_steps(social, f"Boxes3D:{component}")
        assert {step: len(row) for step, row in rows.items()} == {0: 7, 5: 6}


def test_nothing_to_show_is_refused(tmp_path):
    scene = busy_crossing()
    with pytest.raises(UnusableInput, match="no log"):
        record_scenario(tmp_path / "x.rrd", replace(scene, log=None))
    assert list(tmp_path.iterdir()) == []


def test_left_out_vehicles_and_repeated_planning_are_named(tmp_path):
    scene = busy_crossing(steps=30)
    samples = noisy_samples(scene, 1)
    samples.violation[:] = Violation.NONE
    samples.dropped[0, 2], samples.attempts[0, 1:3] = True, 4
    record_scenario(tmp_path / "x.rrd", scene, samples)
    lines = [row[0] for row in read(tmp_path / "x.rrd")["/verdicts"]["TextLog:text"]]
    assert "vehicle track-2: left out, nothing legal was found, 4 planned" in lines
    assert "vehicle track-1: legal, 4 planned" in lines


def test_clearance_is_bumper_to_bumper_and_capped():
    lane = straight_road().centreline[0]
    log = stack([drive(lane, 20, 5, 11), drive(lane, 32, 5, 11)])
    scene = scenario(straight_road(), log)
    np.testing.assert_allclose(clearance(scene, log), 12 - 4.6, atol=1e-3)
    log.valid[1, 6:] = False
    assert clearance(scene, log)[-1] == FREE


def test_people_count_for_clearance_and_are_drawn(tmp_path):
    lane = straight_road().centreline[0]
    log = stack([drive(lane, 20, 0, 11)])
    walker = Trajectories(
        np.full((1, 11, 2), (20, 5), np.float32),
        np.zeros((1, 11), np.float32),
        np.zeros((1, 11, 2), np.float32),
        np.ones((1, 11), np.bool_),
    )
    people = Actors(np.array(["p"]), np.array([5], np.uint8), np.float32([[0.6, 0.6, 1.8]]), walker)
    base = scenario(straight_road(), log)
    scene = type(base)(**{**vars(base), "context": people})
    np.testing.assert_allclose(clearance(scene, log), 5 - 0.95 - 0.3, atol=1e-3)
    record_scenario(tmp_path / "p.rrd", scene)
    record_comparison(tmp_path / "methods.rrd", scene, {"one": noisy_samples(scene, 1)}, {}, {})
    assert all("/world/context" in read(tmp_path / name) for name in ("p.rrd", "methods.rrd"))


def test_of_a_large_map_only_what_is_near_the_traffic_is_drawn(tmp_path):
    near, far = straight_road(100), straight_road(100)
    line = near.centreline[0].astype(np.float64)
    town = road_map([line, *(line + np.array([0.0, 400.0 + 5 * i]) for i in range(300))])
    scene = scenario(town, stack([drive(line, 20, 5, 11)]))
    signals = Signals(np.array([0, 200], np.int32), np.full((2, 11), int(SignalState.GREEN), np.uint8))
    scene = replace(scene, signals=signals)
    roads, shown = surroundings(scene, [scene.log])
    assert (len(roads), shown.lane.tolist()) == (1, [0])
    record_scenario(tmp_path / "town.rrd", scene)
    record_scenario(tmp_path / "road.rrd", replace(scene, map=far, signals=signals.on_lanes(np.array([0]))))
    assert (tmp_path / "town.rrd").stat().st_size < 1.05 * (tmp_path / "road.rrd").stat().st_size


def test_a_scene_away_from_every_road_keeps_its_map():
    scene = busy_crossing(steps=5)
    assert scene.log is not None
    away = replace(scene.log, position=scene.log.position + np.float32(5000))
    roads, signals = surroundings(scene, [away])
    assert (roads, signals) == (scene.map, scene.signals)


def test_no_line_joins_what_was_seen_before_a_gap_with_what_was_seen_after_it(tmp_path):
    lane = straight_road().centreline[0].astype(np.float64)
    log = stack([drive(lane, 20, 10, 101), drive(lane, 60, 10, 101)])
    log.valid[1, 30:60] = False
    scene = scenario(straight_road(), log)
    samples = noisy_samples(scene, 1)
    samples = replace(samples, motion=log[np.newaxis])
    record_scenario(tmp_path / "gap.rrd", scene, samples)
    record_comparison(tmp_path / "methods.rrd", scene, {"one": samples}, {}, {})
    shown = (("gap", "/world/paths"), ("methods", "/world/methods/one/samples"))
    for name, entity in shown:
        (lines,) = read(tmp_path / f"{name}.rrd")[entity]["LineStrips3D:strips"]
        ends = [(round(float(line[0][0])), round(float(line[-1][0]))) for line in lines]
        assert ends == [(20, 120), (60, 89), (120, 160)]
