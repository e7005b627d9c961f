"""Keys go from the environment to the server and nowhere else."""

import pytest

from drivegen.core.errors import UnusableInput
from drivegen.lm.keys import secret
from drivegen.lm.prompt import NoAnswer
from drivegen.lm.records import Mode
from tests.lm.asking import GOOD, model, question, settings
from tests.lm.chat_server import Says, serving

KEY = "sk-very-secret-0123456789"


@pytest.fixture(autouse=True)
def _key(monkeypatch):
    monkeypatch.setenv("MY_KEY", KEY)


def test_the_key_reaches_the_server_and_no_file_row_or_error(tmp_path, caplog):
    echo = f'{{"place": 1, "reason": "{KEY}"}}'
    with serving([Says(echo), Says(KEY, status=401)]) as server:
        asked = model(tmp_path, server.url, key="MY_KEY", mode=Mode.RECORD)
        answer = asked.ask(question())
        with pytest.raises(NoAnswer) as failure:
            asked.ask(question("another"))
    assert server.headers[0]["authorization"] == f"Bearer {KEY}"
    kept = "".join(file.read_text() for file in tmp_path.rglob("*") if file.is_file())
    assert kept
    assert KEY not in f"{kept} {answer} {asked.ledger.calls} {failure.value!r} {failure.value.__cause__!r} {caplog.text}"


@pytest.mark.parametrize("url", ["http://203.0.113.9/v1", "http://example.org/v1", "http://127.0.0.1.example.org/v1"])
def test_a_key_never_goes_out_unencrypted(url):
    with pytest.raises(UnusableInput, match="unencrypted") as refusal:
        secret("MY_KEY", url)
    assert KEY not in str(refusal.value)
    assert secret("", url) == ""


@pytest.mark.parametrize(
    "url", ["https://example.org/v1", "http://127.0.0.1:8000/v1", "http://localhost/v1", "http://[::1]:1/v1"]
)
def test_a_key_goes_encrypted_or_to_this_machine(url):
    assert secret("MY_KEY", url) == KEY


@pytest.mark.parametrize("url", ["ftp://a/v1", "a", "https://", "https://user:password@a/v1", "https://a/v1?key=1"])
def test_what_is_no_plain_url_is_refused_without_repeating_it(url):
    with pytest.raises(UnusableInput) as refusal:
        secret("MY_KEY", url)
    assert "password@" not in str(refusal.value)


def test_a_key_in_the_settings_is_refused_without_repeating_it():
    with pytest.raises(UnusableInput) as refusal:
        settings(key=KEY)
    assert KEY not in str(refusal.value)


def test_the_servers_word_is_answered_from_this_machine_without_a_proxy(tmp_path, monkeypatch):
    monkeypatch.setenv("HTTP_PROXY", "http://203.0.113.9:3128")
    with serving([Says(GOOD)]) as server:
        assert model(tmp_path, server.url, key="MY_KEY").ask(question()).place == 2


@pytest.mark.parametrize("backend", ["openai", "anthropic"])
def test_a_server_of_ones_own_never_gets_the_vendors_key(tmp_path, monkeypatch, backend):
    names = ("OPENAI_API_KEY", "OPENAI_ADMIN_KEY", "ANTHROPIC_API_KEY", "ANTHROPIC_AUTH_TOKEN")
    for name in names:
        monkeypatch.setenv(name, KEY)
    with serving([Says("no", status=400)]) as server, pytest.raises(NoAnswer):
        model(tmp_path, server.url, backend=backend, output="prompted").ask(question())
    assert KEY not in str(server.headers)
