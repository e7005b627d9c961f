"""A stream of random numbers is named by words, and depends on nothing else."""

import os
import subprocess
import sys

from hypothesis import given, settings
from hypothesis import strategies as st

from drivegen.core import seeds

words = st.lists(st.one_of(st.text(st.characters(exclude_characters="\x1f"), max_size=8), st.integers(0, 99)), max_size=3)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**63), words, words)
def test_other_words_give_another_stream(seed, one, other):
    same = [str(w) for w in one] == [str(w) for w in other]
    assert (seeds.derive(seed, *one) == seeds.derive(seed, *other)) == same


def test_words_are_not_run_together():
    assert seeds.derive(1, "ab", "c") != seeds.derive(1, "a", "bc")
    assert seeds.derive(1, 2, 3) != seeds.derive(12, 3)


def test_streams_do_not_depend_on_the_hash_seed_or_the_process():
    code = "from drivegen.core import seeds; print(seeds.derive(7, 'rollout', 'x', 3), seeds.rng(7, 'a').integers(10**9))"
    runs = {
        subprocess.run(
            [sys.executable, "-c", code], env={**os.environ, "PYTHONHASHSEED": value}, capture_output=True, text=True, check=True
        ).stdout
        for value in ("0", "42")
    }
    assert runs == {f"{seeds.derive(7, 'rollout', 'x', 3)} {seeds.rng(7, 'a').integers(10**9)}\n"}


def test_a_derived_seed_fits_into_63_bits():
    assert all(0 <= seeds.derive(seed, "word") < 2**63 for seed in range(200))


def test_words_may_be_bytes_that_are_no_text():
    assert seeds.derive(7, "a \udcff crossing") != seeds.derive(7, "a \udcfe crossing")
