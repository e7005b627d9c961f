"""What calls cost: known where a price list knows the model, else unknown and never nothing."""

import subprocess
import sys
from contextlib import suppress

import pyarrow.parquet as pq
import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.lm.ledger import CALLS, FOLDER, Ledger
from drivegen.lm.prices import estimate, input_tokens, price
from drivegen.lm.prompt import NoAnswer, OverBudget
from drivegen.lm.settings import RecordSettings, overridden
from drivegen.warehouse.database import build, query, read_parts
from tests.lm.asking import GOOD, model, question, settings
from tests.lm.chat_server import Says, serving

OPENAI, ANTHROPIC, OFFLINE = (plugins.load("lm.backends", name) for name in ("openai", "anthropic", "offline"))


def test_a_price_is_per_token_and_unknown_models_have_none():
    assert price("gpt-4o", "openai", 1_000_000, 0) == pytest.approx(2.5)
    assert price("gpt-4o", "openai", 1000, 100) > price("gpt-4o", "openai", 1000, 0) > 0
    assert price("no-such-model", "openai", 1000, 100) is None
    assert price("gpt-4o", "", 1000, 100) is None
    assert price("gpt-4o", "openai", None, 100) is None


def test_an_estimate_counts_calls_tokens_and_dollars(tmp_path):
    role = settings(model="gpt-4o")
    requests = [model(tmp_path, model="gpt-4o").request(question())] * 10
    told = estimate(role, requests, 50)
    assert (told.calls, told.output_tokens) == (10, 500)
    assert told.input_tokens == 10 * input_tokens(requests[0], OPENAI)
    assert told.usd == pytest.approx(price("gpt-4o", "openai", told.input_tokens, 500))
    assert told.most_usd > told.usd
    assert estimate(settings("http://127.0.0.1:1/v1", model="gpt-4o"), requests, 50).usd is None


def test_calls_are_priced_one_by_one_for_a_long_one_is_dearer(tmp_path):
    role = settings(model="gpt-6-luna")
    request = model(tmp_path, model="gpt-6-luna").request(question("x" * 4000))
    one, many = (estimate(role, [request] * count, 120) for count in (1, 1000))
    assert price("gpt-6-luna", "openai", many.input_tokens, many.output_tokens) > 1500 * one.usd
    assert (many.usd, many.most_usd) == (pytest.approx(1000 * one.usd), pytest.approx(1000 * one.most_usd))


def test_the_most_that_calls_cost_holds_all_repairs_which_are_in_no_batch(tmp_path):
    role = settings(model="gpt-4o")
    requests = [model(tmp_path, model="gpt-4o").request(question())]
    plain, mended = (estimate(role, requests, 50, repairs=repairs) for repairs in (0, 3))
    assert (mended.calls, mended.usd) == (plain.calls, plain.usd)
    assert mended.most_usd > 4 * plain.most_usd  # each repair asks what was asked before, and more
    batch = estimate(role, requests, 50, batch=True, repairs=3)
    assert batch.most_usd == pytest.approx(mended.most_usd - plain.most_usd / 2)


def test_a_picture_counts_by_its_size(tmp_path):
    request = model(tmp_path).request(question())
    assert input_tokens(request, OPENAI) - input_tokens(request, OFFLINE) == 2  # 64 x 32 pixels
    assert input_tokens(request, ANTHROPIC) - input_tokens(request, OFFLINE) == 3


def test_money_is_set_aside_before_a_call_and_settled_after_it():
    ledger = Ledger(max_usd=1.0, max_calls=10)
    ledger.set_aside(0.6)
    with pytest.raises(OverBudget):
        ledger.set_aside(0.6)
    ledger.settle(0.6, 0.1)
    ledger.set_aside(0.6)
    ledger.settle(0.6, None)
    ledger.set_aside(0.25)
    with pytest.raises(OverBudget, match=r"0\.9500 of 1 are spent"):
        ledger.set_aside(0.1)


def test_the_ledger_is_a_table_and_every_call_a_row_of_the_warehouse(tmp_path):
    assert Ledger(1.0, 1).table().num_rows == 0
    with serving([Says("{"), Says(GOOD)]) as server:
        asked = model(tmp_path, server.url)
        asked.ask(question())
        asked.ask(question())
    asked.ledger.write(tmp_path / "calls" / "goals.parquet")
    calls = read_parts([tmp_path / "calls" / "goals.parquet"], CALLS)
    build(tmp_path / "all.duckdb", {"calls": calls})
    assert query(tmp_path / "all.duckdb", "select count(*) as n from calls")["n"].to_pylist() == [4]
    [row] = query(tmp_path / "all.duckdb", "from language_model_calls").to_pylist()
    assert (row["calls"], row["replayed"], row["answered"], row["asked_again"]) == (4, 2, 2, 2)
    assert (row["input_tokens"], row["dollars"]) == (480, None)


def test_the_calls_of_every_run_that_asked_somebody_stay(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def run(words: str) -> None:
        asked = model(tmp_path / "records", server.url, retries=0)
        with asked.ledger.kept("goals"), suppress(NoAnswer):
            asked.ask(question(words))

    with serving([Says("no such model", status=404), Says(GOOD)]) as server:
        for words in ("a", "b", "b", "b"):  # refused, answered, replayed twice
            run(words)
    calls = [row for file in FOLDER.glob("*.parquet") for row in pq.read_table(file).to_pylist()]
    assert sorted((call["outcome"], call["replayed"]) for call in calls) == [
        ("answered", False), ("answered", True), ("refused", False)
    ]  # fmt: skip


def test_a_call_that_was_refused_costs_nothing_and_leaves_the_dollars_known(tmp_path):
    with serving([Says("no such model", status=404), Says(hang=True)]) as server:
        asked = model(tmp_path, server.url, retries=0, timeout=0.5)
        for dollars in (0.0, None):  # who does not answer in time may send a bill
            with pytest.raises(NoAnswer):
                asked.ask(question())
            build(tmp_path / "all.duckdb", {"calls": asked.ledger.table()})
            assert query(tmp_path / "all.duckdb", "from language_model_calls")["dollars"].to_pylist() == [dollars]


@pytest.mark.parametrize("budget", ["max_calls", "max_usd"])
def test_an_attempt_without_a_response_counts_against_the_budget_for_it_may_be_billed(tmp_path, monkeypatch, budget):
    monkeypatch.setattr(OPENAI, "vendor", lambda *_: "openai")
    request = model(tmp_path, model="gpt-4o").request(question())
    most = price("gpt-4o", "openai", input_tokens(request, OPENAI), request.max_tokens)
    enough_for_two = {"max_calls": {"max_calls": 2}, "max_usd": {"max_usd": 2 * most}}[budget]
    with serving([Says(hang=True), Says(GOOD)]) as server:
        asked = model(tmp_path, server.url, model="gpt-4o", timeout=0.5, **enough_for_two)
        asked.ask(question())
        assert [(call.outcome, call.cost, call.retries) for call in asked.ledger.calls] == [("answered", "unknown", 1)]
        with pytest.raises(OverBudget):
            asked.ask(question("another"))


def test_lm_words_name_another_model():
    base = settings("http://127.0.0.1:1/v1")
    assert overridden(base, "offline").model == ""
    other = overridden(base, "openai:llama@http://127.0.0.1:8000/v1")
    assert (other.model, other.base_url, other.key) == ("llama", "http://127.0.0.1:8000/v1", "")
    hosted = overridden(base, "anthropic:claude")
    assert (hosted.backend, hosted.base_url, hosted.key) == ("anthropic", "", "ANTHROPIC_API_KEY")
    assert overridden(base, "openai:other").base_url == base.base_url
    for words in ("nobody:x", "openai", "offline:x", ""):
        with pytest.raises(UnusableInput):
            overridden(base, words)
    with pytest.raises(UnusableInput, match="replay"):
        RecordSettings("sometimes", "x").open()


def test_the_client_is_imported_only_when_a_model_is_called():
    code = (
        "import sys, drivegen.lm.model, drivegen.lm.backends.openai, drivegen.lm.backends.anthropic, drivegen.lm.prices;"
        "print([m for m in ('pydantic_ai', 'openai', 'anthropic', 'genai_prices', 'httpx2') if m in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True).stdout == "[]\n"
