"""The rivals' own rules: by what CAT ranks, and how searches in rounds share out their runs."""

from dataclasses import replace

import numpy as np
import pytest

from drivegen.adversaries import advsim, cat, diffscene
from drivegen.adversaries.shared.approach import approaches
from drivegen.adversaries.shared.arena import Arena, Bounds, Ground, everywhere
from drivegen.adversaries.shared.goals import exchanged_goals
from drivegen.core.settings import build, read_section
from drivegen.corner_cases.trials import Variants
from drivegen.drivers import idm
from tests.adversaries.test_adversaries_contract import ground  # noqa: F401  # a fixture
from tests.checking import IDM
from tests.models import ROOT

BUDGET = 10


class Watched:
    """Goals with odds that fall as they come nearer; keeps the order in which they were found best at first."""

    def candidates(self, arena, scenes):
        pool = exchanged_goals(arena, 1, scenes)
        driven = everywhere(arena.trials.run(Variants.unchanged(scenes, arena.trials.steps)).motion, scenes, len(arena.ground.of))
        self.met = approaches(arena.trials, driven, pool.scene, pool.vehicle, pool.motion)
        self.pool = replace(pool, odds=np.minimum(self.met.gap, 50.0).astype(np.float32) / 50 + np.float32(0.01))
        return self.pool

    def varied(self, arena, pool, order):
        self.order = order
        return pool


def test_cat_ranks_overlaps_by_odds_and_time_and_what_never_overlaps_by_its_gap_alone(ground):  # noqa: F811
    source = Watched()
    cat.Chooser(cat.Choosing(per_scene=5, last=5), source).attack(Arena(idm.Plugin(IDM), ground, Bounds("legal", BUDGET, 20), 7))
    meets, gap = source.met.contact >= 0, source.met.gap

    def badness(q):
        worth = float(source.pool.odds[q]) * 0.99 ** (int(source.met.contact[q]) // 5)
        return (0, -worth) if meets[q] else (1, float(gap[q]))

    found = [badness(q) for q in source.order.tolist()]
    assert found == sorted(found)
    assert len(np.unique(gap[~meets])) > 5


def test_cat_remembers_the_last_drives_of_each_scene_though_scenes_take_turns(ground, monkeypatch):  # noqa: F811
    """Candidates are driven by turns in both scenes of a scenario, each as near as the turn is late."""
    turns, given, drives = [], [], {0: [], 1: []}

    def nearness(arena, pool, driven):
        number = np.array([np.count_nonzero(pool.scene[:q] == pool.scene[q]) for q in range(len(pool))])
        turn = max(len(turns) - 1, 0)  # before the first turn all are looked at once
        if turns:
            for scene, own in drives.items():
                own += [turn] if driven.valid[scene].any() else []
        turns.append(turn)
        return np.zeros(len(pool)), (10.0 * (2 * number + pool.scene) + 0.01 * turn).astype(np.float32)

    def ranked(worth, gap):
        given.append(gap)
        return np.argsort(gap, kind="stable")

    monkeypatch.setattr(cat, "_nearness", nearness)
    monkeypatch.setattr(cat, "_ranked", ranked)
    source = Watched()
    cat.Chooser(cat.Choosing(per_scene=5, last=2), source).attack(Arena(idm.Plugin(IDM), ground, Bounds("legal", BUDGET, 20), 7))
    assert min(map(len, drives.values())) > 2
    for scene, own in drives.items():
        least = float(given[-1][source.pool.scene == scene].min())
        assert least == pytest.approx(10.0 * scene + 0.01 * min(own[-2:]), abs=1e-4)


@pytest.mark.parametrize("plugin", [advsim, diffscene])
def test_rounds_are_of_equal_size_whoever_is_beside_in_the_arena(plugin, ground, monkeypatch):  # noqa: F811
    """Beside a scenario in which nobody can attack, whose runs are all left to the end."""
    settings = build(
        plugin.Settings, read_section("attack.adversaries", ROOT / "params.yaml")[plugin.__name__.split(".")[-1]], ""
    )
    only_first = Ground(ground.choices[:1], ground.of[:2], ground.traffic[:2], ground.planner, ground.limits)
    attackers = plugin.attackers
    monkeypatch.setattr(
        plugin, "attackers", lambda arena, scenes, driven: np.where(scenes < 2, attackers(arena, scenes, driven), -1)
    )
    alone, beside = (_rounds(plugin.Plugin(settings), each) for each in (only_first, ground))
    assert beside == alone
    assert max(alone) <= -(-(BUDGET - 1) // settings.rounds)


def _rounds(adversary, ground):  # noqa: F811
    """Runs in the first scenario at every call of `drive`, after the one of the scene as it is."""
    arena, sizes = Arena(idm.Plugin(IDM), ground, Bounds("legal", BUDGET, 20), 7), []
    drive = arena.drive

    def counted(variants, odds=None):
        sizes.append(int((ground.of[variants.scene] == 0).sum()))
        return drive(variants, odds)

    arena.drive = counted
    adversary.attack(arena)
    return sizes[1:]
