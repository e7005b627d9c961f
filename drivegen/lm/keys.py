"""Keys come from the environment only, and go to the configured server only: encrypted, or to this very machine."""

import ipaddress
import os
from urllib.parse import urlsplit

from drivegen.core.errors import MissingTool, UnusableInput

HIDDEN = "[key]"
"""What stands where a server repeated the key in its reply."""


def secret(variable: str, url: str) -> str:
    """The key in the environment variable, "" if none is named or needed, once `url` is known to be safe for it.

    Raises MissingTool where the variable is empty, except for a server on this machine, which needs no key; UnusableInput
    for a URL that is none, holds a password, or would send the key in clear text.
    """
    parts = urlsplit(url)
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
    """`text` without the key, for a server may repeat what it was sent."""
    return text.replace(key, HIDDEN) if key else text


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
