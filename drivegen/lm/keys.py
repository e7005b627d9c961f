"""Keys come from the environment only, and go to the configured server only: encrypted, or to this very machine."""

import base64
import codecs
import html
import ipaddress
import os
import re
import unicodedata
from collections.abc import Callable, Iterator
from urllib.parse import unquote, urlsplit

from drivegen.core.errors import MissingTool, UnusableInput

HIDDEN = "[key]"
"""What stands where a server repeated the key in its reply; all that is kept of a reply that holds it in disguise."""

SHORTEST_SECRET = 12
"""Letters and digits of the shortest key that is looked for in disguise, too; a shorter one only as it stands, and if it is of
letters or of digits alone, such as "none", not at all: honest replies would hold it."""

LAYERS = 2
"""How many encodings may lie on top of one another."""


def secret(variable: str, url: str) -> str:
    """The key in the environment variable, "" if none is named or needed, once `url` is known to be safe for it.

    Raises MissingTool where the variable is empty, except for a server on this machine, which needs no key; UnusableInput
    for a URL that is none, holds a password, or would send the key in clear text.
    """
    try:
        parts = urlsplit(url)
    except ValueError:
        raise UnusableInput("lm: base_url is no address") from None
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise UnusableInput("lm: base_url must begin with https://, or with http:// for a server of your own")
    if parts.username or parts.password or parts.query:
        raise UnusableInput("lm: base_url must hold no user, password or query: keys come from the environment")
    key = os.environ.get(variable, "").strip() if variable else ""
    local = _is_loopback(parts.hostname)
    if variable and not key and not local:
        raise MissingTool(f"the environment variable {variable} holds no key for {parts.hostname}: set it, or use `--lm offline`")
    if key and parts.scheme == "http" and not local:
        raise UnusableInput(f"lm: the key would go to {parts.hostname} unencrypted: use https, or no key")
    return key


def endpoint(url: str) -> str:
    """Host and port, for messages."""
    return urlsplit(url).netloc


def scrubbed(text: str, key: str) -> str:
    """`text` without the key, for a server may repeat what it was sent.

    Nothing is left of a text that holds the key in an encoding: no honest server disguises it.
    """
    if _is_placeholder(key):
        return text
    text = text.replace(key, HIDDEN)
    return HIDDEN if _is_disguised(text, key) else text


def _is_placeholder(key: str) -> bool:
    """Whether servers that ask for no key are given such a one: a short word, or a number."""
    plain = _plain(key)
    return not plain or (len(plain) < SHORTEST_SECRET and (plain.isalpha() or plain.isdigit()))


def _is_disguised(text: str, key: str) -> bool:
    """Whether the letters and digits of the key follow one another in a reading of `text`, in either case or direction."""
    wanted = _plain(key)
    if len(wanted) < SHORTEST_SECRET:
        return False
    return any(wanted in plain or wanted[::-1] in plain for plain in map(_plain, _readings(text)))


def _plain(text: str) -> str:
    return re.sub(r"[^0-9a-z]", "", unicodedata.normalize("NFKC", text).lower())


def _readings(text: str) -> Iterator[str]:
    r"""`text` as it is and decoded in every way of `_DECODERS`, `LAYERS` deep.

    Line ends and tabs that are written out, as in JSON (`\n`), part no run. What is compressed is not looked into.
    """
    layer = {text, re.sub(r"(?<!\\)\\+[nrt]", "", text)}
    yield from layer
    for _ in range(LAYERS):
        layer = {decode(one) for one in layer for decode in _DECODERS} - layer
        yield from layer


def _escapes(text: str) -> str:
    r"""`\u0073`, `\x73`, `\163` and `\U00000073` as they stand in JSON and in source, with any number of backslashes."""
    pattern = r"(?<!\\)\\+(?:u\{([0-9a-fA-F]{1,6})\}|u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|x([0-9a-fA-F]{2})|([0-7]{3}))"
    return re.sub(pattern, lambda m: _character(int(m[5], 8) if m[5] else int(m[1] or m[2] or m[3] or m[4], 16)), text)


def _base64(text: str) -> str:
    """Runs of base64, plain or for URLs, broken into lines or not, from each of the four places where a group may begin."""
    runs = re.findall(r"[0-9A-Za-z+/]{8,}", re.sub(r"[\s\\]+", "", text).translate(_FROM_URL))
    return "\n".join(_bytes(base64.b64decode(_groups(run[skip:], 4, "A"))) for run in runs for skip in range(4))


def _base32(text: str) -> str:
    runs = re.findall(r"[2-7A-Z]{8,}", re.sub(r"\s+", "", text).upper())
    return "\n".join(_bytes(base64.b32decode(_groups(run[skip:], 8, "A"))) for run in runs for skip in range(8))


def _hex(text: str) -> str:
    """Runs of hexadecimal digits, with or without something between the pairs, from either of the two places."""
    runs = re.findall(r"[0-9a-fA-F]{8,}", re.sub(r"0x|\\x|[^0-9a-zA-Z]+", "", text))
    return "\n".join(_bytes(bytes.fromhex(_groups(run[skip:], 2, "0"))) for run in runs for skip in range(2))


def _numbers(text: str) -> str:
    """Lists of character codes."""
    return "".join(_character(int(number)) for number in re.findall(r"\d{2,3}", text))


_FROM_URL = str.maketrans("-_", "+/")

_DECODERS: tuple[Callable[[str], str], ...] = (
    _escapes, unquote, html.unescape, _base64, _base32, _hex, _numbers, lambda text: codecs.decode(text, "rot13")
)  # fmt: skip


def _groups(run: str, length: int, filler: str) -> str:
    """`run`, filled up to whole groups."""
    return run + filler * (-len(run) % length)


def _bytes(raw: bytes) -> str:
    return raw.decode("latin-1")


def _character(code: int) -> str:
    return chr(code) if code < 0x110000 else ""


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
