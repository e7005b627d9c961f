"""Mutation score: which faulty drivers a tester tells from the sound ones that they were made of, and after how many runs.

Every run of a mutated driver stands beside one of the sound driver: in the same scene where traffic is driven as it is, in the
same scenario where somebody searches, against each of the two by itself. A driver is *killed* where it fails in more runs than
the sound one, by McNemar's exact test with recordings as clusters, and by Holm over all drivers of the tester, equivalent ones
included: whoever tests does not know which these are.

The test is of the excess of each recording: under the null hypothesis its sign could as well be the other one. Where no
recording has more than one run in which only one of the two fails, this is McNemar's exact test, one-sided.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray

from drivegen.core.errors import UnusableInput
from drivegen.core.intervals import recording
from drivegen.core.settings import Count, Within
from drivegen.metrics.paired import chance


@dataclass(frozen=True)
class Pairs:
    """R runs of a mutated driver, each beside one of its sound driver: in the same scene, or as late in a search of its own
    in the same scenario.

    Attributes:
        scenario: (R,) str ids. turn: (R,) int64, runs of a lower turn come first; those of one scenario and turn stay together
            and in their order, as the runs of a search do.
        mutant, sound: (R,) object, by what kind of failure each run ended, "" where it did not fail.
    """

    scenario: NDArray[np.str_]
    turn: NDArray[np.int64]
    mutant: NDArray[np.object_]
    sound: NDArray[np.object_]

    @classmethod
    def joined(cls, parts: "Sequence[Pairs]") -> Self:
        """All parts, at least one, one after the other."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__dataclass_fields__))

    @property
    def excess(self) -> NDArray[np.int64]:
        """(R,) 1 where only the mutant fails, -1 where only the sound one does, else 0."""
        return np.asarray((self.mutant != "").astype(np.int64) - (self.sound != ""), np.int64)

    @property
    def by_kind(self) -> dict[str, int]:
        """How much more often the mutant fails by each kind that occurs."""
        kinds = sorted({*self.mutant.tolist(), *self.sound.tolist()} - {""})
        return {kind: int((self.mutant == kind).sum() - (self.sound == kind).sum()) for kind in kinds}

    def by_scenario(self) -> tuple[list[str], dict[str, NDArray[np.float64]]]:
        """Ids (S,) and numbers (S,) of each: runs, and those in which the mutant, the sound one, one of them alone fails."""
        ids, at = np.unique(self.scenario, return_inverse=True)
        happened = {
            "runs": np.ones(len(at)),
            "failed": self.mutant != "",
            "failed_sound": self.sound != "",
            "only_mutant": self.excess > 0,
            "only_sound": self.excess < 0,
        }
        sums = {name: np.bincount(at, value, len(ids)).astype(np.float64) for name, value in happened.items()}
        return ids.tolist(), sums


@dataclass(frozen=True)
class Settings:
    """How drivers are killed.

    Attributes:
        level: the odds, at most, that a tester kills any equivalent driver. looks: numbers of runs after which it is asked who is
            killed by then, rising. draws: orders of the scenarios that are tried for that.
    """

    level: Annotated[float, Within(0, 0.5, above=True)]
    looks: tuple[Count, ...]
    draws: Count

    def __post_init__(self) -> None:
        if not self.looks or list(self.looks) != sorted(set(self.looks)):
            raise UnusableInput(
                "stages/params.yaml: mutation_score.test.looks must be numbers of runs, each above the one before"
            )


def holm(p: NDArray[np.floating], level: float) -> NDArray[np.bool_]:
    """(M,) which of M hypotheses are rejected so that a true one is among them with odds of `level` at most (Holm, 1979)."""
    order, killed = np.argsort(p, kind="stable"), np.zeros(len(p), np.bool_)
    killed[order] = np.logical_and.accumulate(p[order] <= level / np.arange(len(p), 0, -1))
    return killed


def names(by_kind: Mapping[str, int], fails: Sequence[str]) -> bool:
    """Whether one of the kinds by which a driver should fail is among those of the largest excess."""
    most = max(by_kind.values(), default=0)
    return most > 0 and any(by_kind.get(kind, 0) == most for kind in fails)


def scored(
    pairs: Mapping[str, Pairs], fails: Mapping[str, Sequence[str]], settings: Settings, random: np.random.Generator
) -> dict[str, Any]:
    """One tester's score, of M mutated drivers by name; those for which `fails` has no kind are equivalent ones.

    * `killed`: share of the faulty, `false_kills`: of the equivalent; `killed_apart` and `false_kills_apart`: the same if runs
      were independent.
    * `named`: share of the killed faulty ones whose kind is named (`names`); `named_by_guess`: had the one kind been named for
      all of them that most fail by.
    * `first_kill`: the fewest of `looks` by which half of the orders have killed a faulty driver; `runs_to_kill`: the same for
      as many as half of the faulty drivers, each by itself.
    * `curve`: looks, all runs the last, and the share of the faulty killed by then.

    Shares of nothing, and numbers beyond the last look, are None.
    """
    drivers = _drivers(pairs, fails, settings.level)
    faulty = np.array([bool(fails[name]) for name in pairs])
    most = max(each["runs"] for each in drivers.values())
    looks = [*(look for look in settings.looks if look < most), most]
    by_then = _killed_by(list(pairs.values()), looks, settings, random)
    for each, enough in zip(drivers.values(), (by_then.mean(axis=0) >= 0.5).T, strict=True):
        each["runs_to_kill"] = _first(looks, enough)
    bad, good = (
        [each for each, is_bad in zip(drivers.values(), faulty, strict=True) if is_bad == which] for which in (True, False)
    )
    dead = [each for each in bad if each["killed"]]
    return {
        "level": settings.level,
        "runs": float(np.mean([each["runs"] for each in drivers.values()])),
        "recordings": len({recording(name) for each in pairs.values() for name in each.scenario.tolist()}),
        "faulty": len(bad),
        "equivalent": len(good),
        **{name: _share([each[name] for each in bad]) for name in ("killed", "killed_apart")},
        "false_kills": _share([each["killed"] for each in good]),
        "false_kills_apart": _share([each["killed_apart"] for each in good]),
        "named": _share([each["named"] for each in dead]),
        "named_by_guess": _by_guess([each["fails"] for each in dead]),
        "first_kill": _first(looks, by_then[:, :, faulty].any(axis=2).mean(axis=0) >= 0.5),
        "runs_to_kill": _middle([each["runs_to_kill"] for each in bad]),
        "curve": [looks, by_then[:, :, faulty].mean(axis=(0, 2)).tolist() if bad else []],
        "drivers": drivers,
    }


def _drivers(pairs: Mapping[str, Pairs], fails: Mapping[str, Sequence[str]], level: float) -> dict[str, dict[str, Any]]:
    """What is said of each driver by itself."""
    only = {name: (int((each.excess > 0).sum()), int((each.excess < 0).sum())) for name, each in pairs.items()}
    p = np.array([_test(each, np.arange(len(each.turn))) for each in pairs.values()])
    killed, apart = holm(p, level), holm(np.array([chance(np.repeat([1, -1], counts)) for counts in only.values()]), level)
    return {
        name: {
            "runs": len(each.turn),
            "only_mutant": only[name][0],
            "only_sound": only[name][1],
            "p": float(p[m]),
            "killed": bool(killed[m]),
            "killed_apart": bool(apart[m]),
            "kinds": each.by_kind,
            "fails": list(fails[name]),
            "named": names(each.by_kind, fails[name]),
        }
        for m, (name, each) in enumerate(pairs.items())
    }


def _test(pairs: Pairs, rows: NDArray[np.integer]) -> float:
    """P of the runs `rows` alone."""
    excess = pairs.excess[rows]
    some = np.flatnonzero(excess)
    number = np.unique([recording(name) for name in pairs.scenario[rows[some]].tolist()], return_inverse=True)[1]
    return chance(np.rint(np.bincount(number, excess[some])).astype(np.int64))


def _killed_by(
    several: Sequence[Pairs], looks: Sequence[int], settings: Settings, random: np.random.Generator
) -> NDArray[np.bool_]:
    """(draws, looks, M) which drivers are killed by the first so many of their runs; all meet scenarios in one random order."""
    killed = np.zeros((settings.draws, len(looks), len(several)), np.bool_)
    ids = np.unique(np.concatenate([each.scenario for each in several]))
    places = [np.searchsorted(ids, each.scenario) for each in several]
    for draw in killed:
        luck = random.permutation(len(ids))
        orders = [np.lexsort((luck[place], each.turn)) for place, each in zip(places, several, strict=True)]
        for look, here in zip(looks, draw, strict=True):
            here[:] = holm(np.array([_test(each, o[:look]) for each, o in zip(several, orders, strict=True)]), settings.level)
    return killed


def _first(looks: Sequence[int], enough: NDArray[np.bool_]) -> float | None:
    return float(looks[int(np.argmax(enough))]) if enough.any() else None


def _middle(runs: Sequence[float | None]) -> float | None:
    """The lower median, where None is more than any number; None of nothing."""
    return sorted(runs, key=lambda each: np.inf if each is None else each)[(len(runs) - 1) // 2] if runs else None


def _by_guess(fails: Sequence[Sequence[str]]) -> float | None:
    kinds = {kind for each in fails for kind in each}
    return max((sum(kind in each for each in fails) / len(fails) for kind in kinds), default=None)


def _share(which: Sequence[bool]) -> float | None:
    return float(np.mean(which)) if which else None
