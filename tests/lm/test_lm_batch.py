"""Batches: many questions in one job, at half the price; each with an answer or a reason of its own."""

from contextlib import nullcontext
from datetime import timedelta
from time import perf_counter
from unittest.mock import Mock

import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.lm import batch
from drivegen.lm.prices import estimate, price
from drivegen.lm.prompt import NoAnswer, OverBudget
from drivegen.lm.records import Mode
from tests.lm.asking import GOOD, model, outcomes, question, settings
from tests.lm.batch_server import serving_batches

WORDS = [question(f"where to, {i}?") for i in range(3)]


@pytest.fixture(autouse=True)
def _quick(monkeypatch):
    for name in ("FIRST_LOOK", "LAST_LOOK"):
        monkeypatch.setattr(batch, name, timedelta(milliseconds=5))


def test_many_questions_are_one_job_and_what_is_bad_is_asked_again_in_another(tmp_path):
    with serving_batches([GOOD, '{"place": 9}', None, GOOD]) as server:
        asked = model(tmp_path, server.url)
        first, second, third = asked.ask_many(WORDS)
    assert (first.place, second.place) == (2, 2)
    assert isinstance(third, NoAnswer)
    assert third.reason == "refused"
    assert [len(job) for job in server.jobs] == [3, 1]
    assert "less than or equal to 3" in str(server.jobs[1])
    assert outcomes(asked) == {"answered": 2, "asked again": 1, "refused": 1}
    again = model(tmp_path, "http://127.0.0.1:9/v1", mode=Mode.REPLAY).ask_many([WORDS[0], WORDS[1]])
    assert again == [first, second]


def test_anthropics_batches_give_answers_and_reasons_as_openais_do(tmp_path):
    with serving_batches([GOOD, '{"place": 9}', None, GOOD]) as server:
        url = server.url.removesuffix("/v1")
        asked = model(tmp_path, url, backend="anthropic", output="prompted")
        first, second, third = asked.ask_many(WORDS)
    assert (first.place, second.place) == (2, 2)
    assert isinstance(third, NoAnswer)
    assert [len(job) for job in server.jobs] == [3, 1]
    assert "less than or equal to 3" in str(server.jobs[1])
    assert outcomes(asked) == {"answered": 2, "asked again": 1, third.reason: 1}
    assert [call.input_tokens for call in asked.ledger.calls if call.outcome == "answered"] == [120, 120]
    again = model(tmp_path, "http://127.0.0.1:9", mode=Mode.REPLAY, backend="anthropic", output="prompted")
    assert again.ask_many(WORDS[:2]) == [first, second]


def test_what_is_asked_ahead_is_handed_out_with_no_further_call(tmp_path):
    with serving_batches([GOOD, None]) as server:
        asked = model(tmp_path, server.url, batch=True)
        asked.ask_ahead([WORDS[0], WORDS[0], WORDS[1]])  # the same question once
        assert asked.ask(WORDS[0]).place == 2
        with pytest.raises(NoAnswer) as failure:
            asked.ask(WORDS[1])
        assert failure.value.reason == "refused"
        one_by_one = model(tmp_path / "other", server.url)
        one_by_one.ask_ahead(WORDS)
    assert [len(job) for job in server.jobs] == [2]
    assert len(asked.ledger.calls) == 2
    assert not one_by_one.ledger.calls


def test_what_is_recorded_is_not_asked_again(tmp_path):
    with serving_batches([GOOD, GOOD]) as server:
        model(tmp_path, server.url).ask_many(WORDS[:1])
        asked = model(tmp_path, server.url)
        asked.ask_many(WORDS[:2])
    assert [len(job) for job in server.jobs] == [1, 1]
    assert [call.replayed for call in asked.ledger.calls] == [True, False]


def test_a_batch_costs_half_in_estimates_and_before_the_call(tmp_path):
    role = settings(model="gpt-4o")
    requests = [model(tmp_path, model="gpt-4o").request(words) for words in WORDS]
    whole, half = (estimate(role, requests, 50, batch=one) for one in (False, True))
    assert (half.usd, half.most_usd) == (pytest.approx(whole.usd / 2), pytest.approx(whole.most_usd / 2))
    assert half.usd == pytest.approx(price("gpt-4o", "openai", whole.input_tokens, 150) * batch.DISCOUNT)
    with serving_batches([GOOD] * 3) as server:
        asked = model(tmp_path, server.url, max_calls=2)
        with pytest.raises(OverBudget):
            asked.ask_many(WORDS)
    assert not server.jobs


@pytest.mark.parametrize(
    ("failing", "costs", "again"),
    [("/out", ["unknown"] * 3, OverBudget), ("/files", ["0.000000"] * 3, None)],
    ids=["its results cannot be had", "it was never taken"],
)
def test_a_job_that_a_vendor_took_may_be_billed_whatever_comes_after(tmp_path, monkeypatch, failing, costs, again):
    monkeypatch.setattr(plugins.load("lm.backends", "openai"), "vendor", lambda *_: "openai")
    with serving_batches([GOOD] * 3, failing) as server:
        asked = model(tmp_path, server.url, model="gpt-4o", retries=0, max_usd=0.005)  # enough for one such batch
        assert [failure.reason for failure in asked.ask_many(WORDS)] == ["server-error"] * 3
        assert [call.cost for call in asked.ledger.calls] == costs
        with pytest.raises(again) if again else nullcontext():
            asked.ask_many(WORDS)


def test_the_calls_of_a_batch_together_took_the_time_that_it_took(tmp_path):
    with serving_batches([GOOD] * 3) as server:
        asked = model(tmp_path, server.url)
        began = perf_counter()
        asked.ask_many(WORDS)
        assert 0 < sum(call.latency for call in asked.ledger.calls) <= perf_counter() - began


def test_offline_every_question_has_a_typed_failure(tmp_path):
    asked = model(tmp_path, backend="offline", model="", max_calls=0)
    assert [failure.reason for failure in asked.ask_many(WORDS)] == ["no-model"] * 3


def test_a_model_without_a_batch_endpoint_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("pydantic_ai.direct.model_request_batch", Mock(side_effect=NotImplementedError))
    with pytest.raises(UnusableInput, match="one by one"):
        model(tmp_path, "http://127.0.0.1:9/v1").ask_many(WORDS)
