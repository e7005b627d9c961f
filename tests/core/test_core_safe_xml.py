"""XML is never read without care."""

import gzip

import pytest

from drivegen.core import safe_xml
from drivegen.core.errors import UnusableInput

BOMB = b'<!DOCTYPE net [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><net>&b;</net>'
FILE = b'<!DOCTYPE net [<!ENTITY x SYSTEM "file:///etc/hostname">]><net>&x;</net>'


@pytest.mark.parametrize(
    ("raw", "reason"),
    [
        (b"", "empty"),
        (b"no xml", "not-xml"),
        (b"<net><edge></net>", "not-xml"),
        (BOMB, "xml-dtd"),
        (FILE, "xml-dtd"),
        (b"<nodes/>", "wrong-root"),
        (b"<net><edge>", "truncated"),
        (b"<net><edge id='a", "truncated"),
        (gzip.compress(b"<net/>" * 100, mtime=0)[:-20], "truncated"),
        (b"\x1f\x8bnonsense", "truncated"),
        (gzip.compress(b"<net>" + b" " * 10_000 + b"</net>", mtime=0), "too-large"),
    ],
)
def test_files_that_are_no_sound_xml_are_refused_by_name(raw: bytes, reason: str) -> None:
    with pytest.raises(UnusableInput, match=r"city\.net\.xml") as refusal:
        safe_xml.parse(raw, "city.net.xml", root="net", max_bytes=5000)
    assert refusal.value.reason == reason


def test_gzipped_files_are_read() -> None:
    assert safe_xml.parse(gzip.compress(b'<net version="1"/>', mtime=0), "x.net.xml.gz", root="net").get("version") == "1"


def test_few_bytes_that_would_become_much_are_refused_before_they_do(monkeypatch: pytest.MonkeyPatch) -> None:
    bomb = gzip.compress(b"<net>" + b"<a/>" * 1_000_000 + b"</net>", mtime=0)
    assert len(bomb) < 6_000
    monkeypatch.setattr(safe_xml, "_tree", None)  # nobody gets as far as parsing
    with pytest.raises(UnusableInput, match=r"city\.net\.xml is larger than 1024 kB") as refusal:
        safe_xml.parse(bomb, "city.net.xml")
    assert refusal.value.reason == "too-large"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("<net>" + "<a/>" * 60 + "</net>", "more than 50 elements"),
        ("<net>" + "<a b='' c=''/>" * 40 + "</net>", "more than 70 attributes"),
        ("<net>" + "<a>" * 20 + "</a>" * 20 + "</net>", "nested more than 9 deep"),
    ],
)
def test_elements_attributes_and_depth_are_bounded(
    monkeypatch: pytest.MonkeyPatch, encoding: str, text: str, sentence: str
) -> None:
    for name, most in (("ELEMENTS", 50), ("ATTRIBUTES", 70), ("DEPTH", 9)):
        monkeypatch.setattr(safe_xml, f"MAX_{name}", most)
    with pytest.raises(UnusableInput, match=rf"city\.net\.xml has (elements )?{sentence}") as refusal:
        safe_xml.parse(text.encode(encoding), "city.net.xml")
    assert refusal.value.reason == "too-large"


def test_as_deep_as_is_welcome_is_read() -> None:
    levels = safe_xml.MAX_DEPTH - 1
    assert safe_xml.parse(b"<net>" + b"<a>" * levels + b"</a>" * levels + b"</net>", "x").tag == "net"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('<net><edge/><include href="/etc/hostname"/></net>', "xml-include"),
        ('<net><include xmlns="other" href="more.xml"/></net>', "xml-include"),
        (f'<net xmlns:n="{"u" * 201}"><n:a/><n:b/></net>', "too-large"),
    ],
)
def test_other_files_and_long_namespaces_are_refused(encoding: str, text: str, reason: str) -> None:
    with pytest.raises(UnusableInput, match=r"^city\.net\.xml") as refusal:
        safe_xml.parse(text.encode(encoding), "city.net.xml")
    assert refusal.value.reason == reason


def test_a_namespace_of_usual_length_is_read() -> None:
    assert safe_xml.parse(b'<n:net xmlns:n="urn:roads"/>', "x").tag == "{urn:roads}net"
