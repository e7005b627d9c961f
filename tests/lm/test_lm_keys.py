"""Keys go from the environment to the server and nowhere else."""

import base64
import codecs
import json
import re
from urllib.parse import quote

import pytest
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st

from drivegen.core.errors import UnusableInput
from drivegen.lm.keys import HIDDEN, scrubbed, secret
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


@pytest.mark.parametrize(
    "url", ["ftp://a/v1", "a", "https://", "http://[::1", "https://user:password@a/v1", "https://a/v1?key=1"]
)
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
    names = ("OPENAI_API_KEY", "OPENAI_ADMIN_KEY", "ANTHROPIC_API_KEY", "ANTHROPIC_AUTH_TOKEN", "OPENAI_ORG_ID")
    for name in names:
        monkeypatch.setenv(name, KEY)
    for name in ("OPENAI_CUSTOM_HEADERS", "ANTHROPIC_CUSTOM_HEADERS"):
        monkeypatch.setenv(name, f"X-Gateway: {KEY}\nAuthorization: Bearer {KEY}")
    with serving([Says("no", status=400)]) as server, pytest.raises(NoAnswer):
        model(tmp_path, server.url, backend=backend, output="prompted").ask(question())
    assert KEY not in str(server.headers)


ENCODINGS = {
    "JSON escapes": lambda text: "".join(f"\\u{ord(letter):04x}" for letter in text),
    "braced escapes": lambda text: "".join(f"\\u{{{ord(letter):x}}}" for letter in text),
    "an escaped dash": lambda text: text.replace("-", "\\u002d"),
    "hexadecimal escapes": lambda text: "".join(f"\\x{ord(letter):02X}" for letter in text),
    "octal escapes": lambda text: "".join(f"\\{ord(letter):03o}" for letter in text),
    "JSON in JSON": lambda text: json.dumps(json.dumps("".join(f"\\u{ord(letter):04x}" for letter in text))),
    "percent": lambda text: "".join(f"%{ord(letter):02X}" for letter in text),
    "percent where needed": lambda text: quote(quote(text, safe="")),
    "HTML": lambda text: "".join(f"&#x{ord(letter):x};" for letter in text),
    "HTML, decimal": lambda text: "".join(f"&#{ord(letter)};" for letter in text),
    "base64": lambda text: base64.b64encode(text.encode()).decode(),
    "base64 for URLs": lambda text: base64.urlsafe_b64encode(text.encode()).decode().rstrip("="),
    "base64 after other words": lambda text: base64.b64encode(b"the key: " + text.encode()).decode(),
    "base64 in lines": lambda text: base64.encodebytes((text * 4).encode()).decode(),
    "base64 in lines of JSON": lambda text: json.dumps({"why": base64.encodebytes((text * 4).encode()).decode()}),
    "hex in lines of JSON": lambda text: json.dumps("\n".join(re.findall("..?", (text * 4).encode().hex()))),
    "base64 twice": lambda text: base64.b64encode(base64.b64encode(text.encode())).decode(),
    "base32": lambda text: base64.b32encode(text.encode()).decode(),
    "hex": lambda text: text.encode().hex(),
    "hex with colons": lambda text: text.encode().hex(":"),
    "codes": lambda text: str(list(text.encode())),
    "backwards": lambda text: text[::-1],
    "the other case": str.swapcase,
    "rot13": lambda text: codecs.encode(text, "rot13"),
    "letter by letter": " ".join,
    "invisible letters between": "\u200b".join,
    "two strings": lambda text: f'{text[:9]}", "{text[9:]}',
    "full width": lambda text: "".join(chr(ord(letter) + 0xFEE0) for letter in text),
}


@pytest.mark.parametrize("encoding", ENCODINGS)
@given(
    key=st.from_regex(r"\Ask-[A-Za-z0-9_-]{8,40}[A-Za-z0-9]{12}\Z"),
    before=st.text(max_size=9),
    after=st.text(st.sampled_from('abcXYZ019 -=%\\"{}'), max_size=9),
)
@examples(max_examples=15, deadline=None)
def test_nothing_is_kept_of_a_reply_that_holds_the_key_in_an_encoding(encoding, key, before, after):
    disguised = f"{before} {ENCODINGS[encoding](key)} {after}"
    assert scrubbed(disguised, key) in (HIDDEN, f"{before} {HIDDEN} {after}")


@given(text=st.text(max_size=300), key=st.from_regex(r"\Ask-[A-Za-z0-9]{20}\Z"))
@examples(max_examples=50, deadline=None)
def test_a_reply_without_the_key_is_kept_as_it_is(text, key):
    assert scrubbed(text, key) == text


@pytest.mark.parametrize("key", ["", "none", "token-abc"])
def test_a_placeholder_in_place_of_a_key_hides_no_reply(key):
    reply = '{"place": 1, "reason": "it is the nearest one, none, %6Eo%6Ee, token-abc, token abc"}'
    assert scrubbed(reply, key) == reply


def test_a_short_key_that_is_no_word_is_hidden_as_it_stands():
    assert scrubbed("it is token-abc123, not token abc123", "token-abc123") == f"it is {HIDDEN}, not token abc123"


@pytest.mark.parametrize("backend", ["openai", "anthropic"])
def test_a_variable_puts_no_other_key_in_the_place_of_ours(tmp_path, monkeypatch, backend):
    monkeypatch.setenv("MY_KEY", KEY)
    for name in ("OPENAI_CUSTOM_HEADERS", "ANTHROPIC_CUSTOM_HEADERS"):
        monkeypatch.setenv(name, "Authorization: Bearer of-a-gateway\nX-Api-Key: of-a-gateway")
    with serving([Says("no", status=400)]) as server, pytest.raises(NoAnswer):
        model(tmp_path, server.url, backend=backend, output="prompted", key="MY_KEY").ask(question())
    assert "of-a-gateway" not in str(server.headers)
    assert server.headers[0]["authorization"] == f"Bearer {KEY}"


def test_an_escaped_key_reaches_no_record(tmp_path):
    disguised = KEY.replace("-", "\\u002d")
    with serving([Says(f'{{"place": 1, "reason": "{disguised}"}}'), Says(GOOD)]) as server:
        model(tmp_path, server.url, key="MY_KEY", mode=Mode.RECORD).ask(question())
    kept = [json.loads(file.read_text()) for file in tmp_path.rglob("*.json")]
    assert len(kept) == 2
    assert KEY not in json.dumps(kept).replace("\\\\u002d", "-")
