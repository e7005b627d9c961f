"""Record and replay: a rerun calls nobody, the files are the same bytes, and what is missing is named."""

from datetime import timedelta
from errno import ENOSPC
from unittest.mock import Mock

import pytest
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st

from drivegen.core.errors import MissingTool
from drivegen.lm import batch, records
from drivegen.lm.backends.base import Reply, Request, Turn
from drivegen.lm.prompt import DamagedRecord, NoAnswer
from drivegen.lm.records import Mode, Records, key_of
from tests.lm.asking import GOOD, model, outcomes, question, settings
from tests.lm.batch_server import serving_batches
from tests.lm.chat_server import Says, serving

NOBODY = "http://127.0.0.1:9/v1"


def content(folder):
    return {file.relative_to(folder): file.read_bytes() for file in folder.rglob("*.json")}


def test_a_rerun_gives_the_same_answers_without_a_call_or_a_changed_byte(tmp_path):
    with serving([Says("{"), Says(GOOD)]) as server:
        first = model(tmp_path, server.url).ask(question())
    before = content(tmp_path)
    assert len(before) == 2  # the bad reply, and the good one
    again = model(tmp_path, NOBODY, mode=Mode.REPLAY)
    assert again.ask(question()) == first
    assert [(call.replayed, call.cost) for call in again.ledger.calls] == [(True, "0.000000")] * 2
    assert content(tmp_path) == before


def test_recording_twice_gives_the_same_bytes(tmp_path):
    with serving([Says(GOOD)]) as server:
        for _ in range(2):
            model(tmp_path / "a", server.url, mode=Mode.RECORD).ask(question())
        model(tmp_path / "b", server.url, mode=Mode.RECORD).ask(question())
    assert len(server.requests) == 3
    assert content(tmp_path / "a") == content(tmp_path / "b")


def test_a_failure_that_was_recorded_is_replayed_as_that_failure(tmp_path):
    with serving([Says("no")]) as server, pytest.raises(NoAnswer):
        model(tmp_path, server.url).ask(question())
    with pytest.raises(NoAnswer) as failure:
        model(tmp_path, NOBODY, mode=Mode.REPLAY).ask(question())
    assert failure.value.reason == "invalid-answer"


def test_a_miss_names_the_missing_prompt(tmp_path):
    with pytest.raises(MissingTool, match=r"little-model .*where to\?.*test-1"):
        model(tmp_path, NOBODY, mode=Mode.REPLAY).ask(question())


def test_nothing_is_kept_when_off(tmp_path):
    with serving([Says(GOOD)]) as server:
        model(tmp_path, server.url, mode=Mode.OFF).ask(question())
    assert content(tmp_path) == {}


def test_calls_whose_replies_find_no_room_are_rows_all_the_same_and_cost_no_other_reply(tmp_path, monkeypatch):
    full = Mock(side_effect=[OSError(ENOSPC, "No space left on device"), None, None])
    monkeypatch.setattr(records, "write_json", full)
    with serving([Says(GOOD)]) as server:
        alone = model(tmp_path, server.url)
        with pytest.raises(OSError, match="No space"):
            alone.ask(question())
    assert outcomes(alone) == {"answered": 1}
    monkeypatch.setattr(batch, "FIRST_LOOK", timedelta(milliseconds=5))
    full.side_effect = [OSError(ENOSPC, "No space left on device"), None, None]
    with serving_batches([GOOD] * 3) as server:
        together = model(tmp_path, server.url)
        with pytest.raises(OSError, match="No space"):
            together.ask_many([question(words) for words in "abc"])
    assert outcomes(together) == {"answered": 3}
    assert full.call_count == 1 + 3


def test_a_file_that_does_not_hold_what_was_recorded_is_named(tmp_path):
    with serving([Says(GOOD)]) as server:
        model(tmp_path, server.url).ask(question())
    [file] = tmp_path.rglob("*.json")
    whole = file.read_bytes()
    other = whole.replace(rb"\"place\": 2", rb"\"place\": 3")
    assert other != whole
    for broken in (b"", b"[]", b'{"reply": {"text": 3, "input_tokens": 1, "output_tokens": 1}}', whole[:50], other):
        file.write_bytes(broken)
        with pytest.raises(DamagedRecord, match=file.name):
            model(tmp_path, NOBODY, mode=Mode.REPLAY).ask(question())


def test_the_key_depends_on_everything_that_the_reply_depends_on(tmp_path):
    asked = model(tmp_path)
    requests = [asked.request(question()), asked.request(question(), sample=1), asked.request(question("elsewhere"))]
    requests += [asked.request(question(), turns=(Turn("a", "b"),)), model(tmp_path, model="other").request(question())]
    requests += [model(tmp_path, output="prompted").request(question()), model(tmp_path, max_tokens=9).request(question())]
    assert len({key_of(request) for request in requests}) == len(requests)
    assert key_of(asked.request(question())) == key_of(model(tmp_path, NOBODY, timeout=1.0).request(question()))


@given(text=st.text(), words=st.text())
@examples(max_examples=20, deadline=None)
def test_any_text_survives_being_kept(tmp_path_factory, text, words):
    folder = tmp_path_factory.mktemp("records")
    request = Request("m", "p", "i", (words,), (), {}, "native", settings().max_tokens, 0)
    kept = Records(folder, Mode.AUTO)
    kept.keep(request, Reply(text, 1, None, 3))
    assert kept.find(request) == Reply(text, 1, None, 0)
