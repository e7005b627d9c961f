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
