"""What every backend keeps to: each file of the folder is tried the moment it exists."""

import json
from concurrent.futures import ThreadPoolExecutor

import pytest

from drivegen.core import plugins
from drivegen.core.errors import UnusableInput
from drivegen.lm.prompt import NoAnswer, OverBudget
from drivegen.lm.records import Mode
from tests.lm.asking import GOOD, model, question, settings
from tests.lm.chat_server import Says, serving

BACKENDS = plugins.names("lm.backends")


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_backend_fails_with_a_type_where_nobody_answers(tmp_path, backend):
    name = "" if backend == "offline" else "m"
    nobody = {"base_url": "http://127.0.0.1:9", "retries": 0, "timeout": 1.0}
    asked = model(tmp_path, mode=Mode.OFF, backend=backend, model=name, output="prompted", **nobody)
    with pytest.raises(NoAnswer) as failure:
        asked.ask(question())
    assert failure.value.reason in ("no-model", "unreachable")


def test_a_model_that_cannot_be_asked_so_is_said_to_be_so(tmp_path):
    with pytest.raises(UnusableInput, match="prompted"):
        model(tmp_path, "http://127.0.0.1:9", mode=Mode.OFF, backend="anthropic", output="native").ask(question())


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_backend_says_what_a_picture_costs(backend):
    plugin = plugins.load("lm.backends", backend)
    assert 0 <= plugin.image_tokens(64, 64) <= plugin.image_tokens(768, 768)


def test_settings_that_make_no_sense_are_named():
    for wrong in ({"backend": "nobody"}, {"output": "loud"}, {"model": ""}, {"timeout": 0.0}, {"retries": -1}):
        with pytest.raises(UnusableInput, match="lm"):
            settings(**wrong)


def test_anthropics_protocol_is_spoken_with_the_key(tmp_path, monkeypatch):
    monkeypatch.setenv("MY_KEY", "secret")
    content = [{"type": "text", "text": GOOD}]
    told = {"id": "x", "type": "message", "role": "assistant", "model": "m", "content": content, "stop_reason": "end_turn"}
    body = json.dumps({**told, "usage": {"input_tokens": 7, "output_tokens": 5}}).encode()
    with serving([Says(body=body)]) as server:
        url = server.url.removesuffix("/v1")
        asked = model(tmp_path, url, backend="anthropic", output="prompted", key="MY_KEY")
        assert asked.ask(question()).place == 2
    assert server.headers[0]["authorization"] == "Bearer secret"
    assert server.headers[0]["accept-encoding"] == "identity"  # a reply that unpacks to more than it says is refused
    assert "image/png" in str(server.requests[0])
    assert asked.ledger.calls[0].input_tokens == 7


def test_many_may_ask_at_once_and_the_budget_holds(tmp_path):
    def ask(i):
        try:
            return asked.ask(question(), sample=i).place
        except OverBudget:
            return 0

    with serving([Says(GOOD)]) as server:
        asked = model(tmp_path, server.url, mode=Mode.OFF, max_calls=5)
        with ThreadPoolExecutor(4) as pool:
            answers = sorted(pool.map(ask, range(8)))
    assert answers == [0, 0, 0, 2, 2, 2, 2, 2]
    assert len(server.requests) == 5
