"""The command line works with the numbers of params.yaml, which it repeats."""

from pathlib import Path

from drivegen.cli import _settings
from stages import _door, ingest, place, rollout

PARAMS = Path(__file__).parents[2] / "params.yaml"


def test_generation_is_that_of_the_rollout_stage():
    assert _settings.generation(drop_illegal=False) == _door.read_params("rollout", rollout.Params, PARAMS).generation


def test_logged_scenes_are_selected_as_by_the_ingest_stage():
    params = _door.read_params("ingest", ingest.Params, PARAMS)
    assert _settings.selection(params.selection.max_vehicles) == params.selection


def test_new_scenes_begin_as_those_of_the_place_stage():
    params = _door.read_params("place", place.Params, PARAMS)
    ours = _settings.initial(params.vehicles)
    assert (ours.horizon, ours.shares, ours.map_radius, ours.longest_cycle, ours.placement) == (
        params.horizon, params.shares, params.map_radius, params.longest_cycle, params.settings,
    )  # fmt: skip
