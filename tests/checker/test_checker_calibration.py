from dataclasses import replace

import numpy as np
import pytest

from drivegen.checker.calibration import calibrate, logged_severities, pass_rates
from drivegen.checker.limits import FLAGS, LIMITED, RULES, Limits
from drivegen.checker.scene import check_samples
from drivegen.core.errors import UnusableInput
from tests.checking import LIMITS
from tests.scenes import beside, busy_crossing, drive, scenario, stack, straight_road

ROAD = straight_road()
LINE = ROAD.centreline[0].astype(np.float64)


@pytest.fixture(scope="module")
def logs():
    """120 noisy tracks; two of them brake as nobody should."""
    random = np.random.default_rng(5)
    made = []
    for i in range(30):
        tracks = [drive(LINE, 5 + 70 * n, random.uniform(4, 14), 80, random.uniform(-1, 0.5)) for n in range(4)]
        if i < 2:
            tracks[3] = drive(LINE, 215, 14, 80, -11.0)
        clean = stack(tracks)
        noise = random.normal(0, 0.05, clean.position.shape).astype(np.float32)
        made.append(scenario(ROAD, replace(clean, position=clean.position + noise), f"log-{i}"))
    return made


def test_99_percent_of_logged_tracks_pass_each_rule_and_each_flag(logs):
    calibration = calibrate([logged_severities(log, LIMITS) for log in logs], LIMITS, 0.99)
    assert calibration.tracks == 120
    assert all(rate >= 0.99 for name, rate in calibration.pass_rate.items() if name != "legal")
    verdicts = [check_samples(log, log.log[np.newaxis], calibration.limits)[0] for log in logs]
    assert np.mean(np.concatenate(verdicts, axis=1) == 0) == pytest.approx(calibration.pass_rate["legal"])


def test_limits_follow_the_quantile_but_never_fall_below_the_floor(logs):
    strict = calibrate([logged_severities(log, LIMITS) for log in logs], LIMITS, 0.8).limits
    lenient = calibrate([logged_severities(log, LIMITS) for log in logs], LIMITS, 0.999).limits
    assert lenient.braking > 10
    assert strict.braking == LIMITS.braking
    assert all(getattr(strict, rule) >= getattr(LIMITS, rule) for rule in LIMITED if rule != "yield_gap")
    assert strict.yield_gap == LIMITS.yield_gap


def test_yield_gaps_are_calibrated_downwards():
    severity = np.full((100, len(RULES)), -np.inf, np.float32)
    severity[:, RULES.index("yield_gap")] = -0.2
    assert calibrate([severity], LIMITS, 0.99).limits.yield_gap == pytest.approx(0.2, abs=2e-3)


def test_a_flag_with_several_rules_still_passes_99_percent():
    """One per cent of the tracks break each of six rules of one flag, never the same ones."""
    severity = np.zeros((1000, len(RULES)), np.float32)
    for i, rule in enumerate(("acceleration", "braking", "lateral_acceleration", "velocity_error", "jump", "velocity_step")):
        severity[10 * i : 10 * i + 10, RULES.index(rule)] = np.arange(100, 110)
    rates = calibrate([severity], LIMITS, 0.99).pass_rate
    assert FLAGS.count(FLAGS[RULES.index("braking")]) == 6
    assert rates["ACCELERATION"] >= 0.99


def test_limits_survive_json_and_say_what_is_wrong_with_it(logs):
    limits = calibrate([logged_severities(log, LIMITS) for log in logs], LIMITS, 0.99).limits
    assert Limits.from_json(limits.to_json(), "limits.json") == limits
    assert Limits.from_severities(limits.severities()) == limits
    with pytest.raises(UnusableInput, match=r"limits\.json.*calibrate"):
        Limits.from_json({"speed": 3.0}, "limits.json")
    with pytest.raises(UnusableInput, match=r"limits\.json\.speed must be float, not 'fast'"):
        Limits.from_json(limits.to_json() | {"speed": "fast"}, "limits.json")
    with pytest.raises(UnusableInput, match=r"limits\.json\.overlap must be at least 0, not -0\.1"):
        Limits.from_json(limits.to_json() | {"overlap": -0.1}, "limits.json")


def test_without_logs_there_is_nothing_to_calibrate_on():
    bare = replace(busy_crossing(), log=None)
    assert logged_severities(bare, LIMITS).shape == (0, len(RULES))
    with pytest.raises(UnusableInput, match="no logged track"):
        calibrate([logged_severities(bare, LIMITS)], LIMITS, 0.99)
    assert pass_rates(np.zeros((0, len(RULES)), np.float32), LIMITS)["legal"] is None


def test_who_is_parked_beside_the_lanes_is_not_calibrated_on():
    driven, kerb = drive(LINE, 20, 8, 40), drive(beside(LINE, -3.0), 60, 0, 40)
    alone = logged_severities(scenario(ROAD, stack([driven])), LIMITS)
    assert (logged_severities(scenario(ROAD, stack([driven, kerb])), LIMITS) == alone).all()
    waiting = drive(LINE, 60, 0, 40)
    assert len(logged_severities(scenario(ROAD, stack([driven, waiting])), LIMITS)) == 2


def test_severities_do_not_depend_on_the_limits():
    log = busy_crossing()
    other = replace(LIMITS, overlap=3.0, off_road=2.0, yield_gap=0.1)
    assert (logged_severities(log, LIMITS) == logged_severities(log, other)).all()
