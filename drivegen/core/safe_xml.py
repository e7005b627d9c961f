"""Every XML file that enters goes through here: size cap, no DTD, no entities, no network.

netconvert 1.28 includes local files through external entities and spends minutes on entity bombs, and libsumo dies on
malformed networks, so nothing that was not written by this program reaches either of them unread. gzip is unpacked
under the same cap.
"""

import zlib
from gzip import GzipFile
from io import BytesIO
from typing import Any
from xml.etree.ElementTree import Element, ParseError  # the types only: parsing is defusedxml's
from xml.parsers.expat import errors

from defusedxml import ElementTree
from defusedxml.common import DefusedXmlException

from drivegen.core.errors import UnusableInput

MAX_BYTES = 400 * 1024 * 1024
"""Largest file that is parsed, unpacked [bytes]: above the largest city network that SUMO's examples hold."""

_GZIP = b"\x1f\x8b"

_CUT_OFF = tuple(
    errors.codes[sentence]
    for sentence in (errors.XML_ERROR_NO_ELEMENTS, errors.XML_ERROR_UNCLOSED_TOKEN, errors.XML_ERROR_PARTIAL_CHAR)
)
"""What expat calls a file that ends too early."""


def parse(raw: bytes, place: str, root: str | None = None, max_bytes: int = MAX_BYTES) -> Element:
    """The root element of `raw`, plain or gzipped.

    Raises UnusableInput, naming `place`, for anything that is not well-formed XML, holds a DTD or an entity, is larger
    than `max_bytes` unpacked, or has another root element than `root`.
    """
    data = unpack(raw, place, max_bytes)
    try:
        element: Any = ElementTree.fromstring(data, forbid_dtd=True)
    except DefusedXmlException as error:
        raise UnusableInput(f"{place}: the XML holds a DTD or an entity, which is refused", reason="xml-dtd") from error
    except ParseError as error:
        reason = "truncated" if error.code in _CUT_OFF else "not-xml"
        raise UnusableInput(f"{place} is not XML: {error}", reason=reason) from error
    except (UnicodeError, LookupError, ValueError) as error:
        raise UnusableInput(f"{place} is not XML: {error}", reason="not-xml") from error
    if root is not None and element.tag != root:
        raise UnusableInput(f"{place}: the root element is <{element.tag}>, not <{root}>", reason="wrong-root")
    return element  # type: ignore[no-any-return]


def unpack(raw: bytes, place: str, max_bytes: int = MAX_BYTES) -> bytes:
    """`raw`, gunzipped if it is gzipped; raises UnusableInput if it is empty, truncated or larger than `max_bytes`."""
    if not raw:
        raise UnusableInput(f"{place} is empty", reason="empty")
    if raw.startswith(_GZIP):
        try:
            with GzipFile(fileobj=BytesIO(raw)) as stream:  # several members, as SUMO's own files may have
                data = stream.read(max_bytes + 1)
        except EOFError as error:
            raise UnusableInput(f"{place} ends in the middle of its gzip stream", reason="truncated") from error
        except (OSError, zlib.error) as error:
            raise UnusableInput(f"{place} is not a sound gzip file: {error}", reason="truncated") from error
        raw = data
    if len(raw) > max_bytes:
        raise UnusableInput(f"{place} is larger than {max_bytes // 1024} kB", reason="too-large")
    return raw
