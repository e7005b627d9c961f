from dataclasses import replace

import numpy as np

from drivegen.core.first_frame import FORESEEN, first_frame
from drivegen.core.signals import Signals, SignalState
from tests.futures import with_riders
from tests.scenes import busy_crossing

G, Y, R, U = SignalState.GREEN, SignalState.YELLOW, SignalState.RED, SignalState.UNKNOWN


def test_who_moves_goes_on_for_a_while_who_stands_stays_and_who_comes_later_does_not_come():
    scene = with_riders(busy_crossing())
    rider = first_frame(scene).context
    assert rider.track_id.tolist() == ["rider"]
    known = round(FORESEEN / 0.1) + 1
    assert rider.motion.valid[0].tolist() == [True] * known + [False] * (101 - known)
    start, velocity = scene.context.motion.position[0, 0], scene.context.motion.velocity[0, 0]
    np.testing.assert_allclose(rider.motion.position[0, 10], start + velocity, atol=1e-4)
    np.testing.assert_allclose(rider.motion.velocity[0], np.tile(velocity, (101, 1)))
    halted = replace(scene.context.motion, velocity=0 * scene.context.motion.velocity)
    still = first_frame(replace(scene, context=replace(scene.context, motion=halted))).context.motion
    assert still.valid.all()
    assert (still.position == start).all()


def test_there_is_no_log_and_signals_are_known_at_step_0_alone():
    scene = busy_crossing()
    shown = first_frame(scene)
    assert shown.log is None
    np.testing.assert_array_equal(shown.signals.state[:, 0], scene.signals.state[:, 0])
    assert (shown.signals.state[:, 1:] == U).all()
    assert shown.map is scene.map
    assert shown.vehicles is scene.vehicles


def test_an_unknown_signal_is_taken_to_show_what_it_showed_last():
    state = np.array([[R, U, U, G, U], [U, U, Y, U, R], [G, G, R, R, G]], np.uint8)
    held = Signals(np.arange(3, dtype=np.int32), state).held().state
    assert held.tolist() == [[R, R, R, G, G], [U, U, Y, Y, R], [G, G, R, R, G]]
