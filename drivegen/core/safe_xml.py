"""Every XML file that enters goes through here: bounds on bytes, elements, attributes and depth, no DTD, no entities, no network.

netconvert 1.28 includes other files through external entities and `<include>` and spends minutes on entity bombs, and libsumo
dies on malformed networks, so nothing that was not written by this program reaches either of them unread. gzip is unpacked
under the same cap. Bytes alone bound little: an element takes four of them in a file and two hundred in memory.
"""

import zlib
from gzip import GzipFile
from io import BytesIO
from typing import Any
from xml.etree.ElementTree import Element, ParseError, TreeBuilder  # no parser: that is defusedxml's
from xml.parsers.expat import errors

from defusedxml import ElementTree
from defusedxml.common import DefusedXmlException

from drivegen.core.errors import UnusableInput, naming

MAX_BYTES = 400 * 1024 * 1024
"""Largest file that is parsed, unpacked [bytes]: above the largest city network that SUMO's examples hold."""

MAX_ELEMENTS, MAX_ATTRIBUTES = 5_000_000, 20_000_000
"""What a network of `MAX_BYTES` holds: in SUMO's a tag takes 80 to 105 bytes, an attribute 20 to 27."""

MAX_DEPTH = 100
"""Elements within elements; no format that is read here has more than about ten."""

MAX_NAMESPACE = 200
"""Letters of a namespace: every name in it repeats them in memory."""

MAX_RATIO = 100
"""How many times its size a gzipped file may unpack to; networks do to about ten times."""

_SMALL = 1024 * 1024
"""Up to so many bytes any ratio is welcome."""

_GZIP = b"\x1f\x8b"

_CUT_OFF = tuple(
    errors.codes[sentence]
    for sentence in (errors.XML_ERROR_NO_ELEMENTS, errors.XML_ERROR_UNCLOSED_TOKEN, errors.XML_ERROR_PARTIAL_CHAR)
)
"""What expat calls a file that ends too early."""


class _Tree(TreeBuilder):
    """Elements of short names. Raises UnusableInput for a long namespace, before any name repeats it."""

    def start_ns(self, prefix: str, uri: str) -> None:
        """Called by the parser where a namespace begins."""
        if len(uri) > MAX_NAMESPACE:
            raise UnusableInput(f"the namespace {prefix!r} has more than {MAX_NAMESPACE} letters", reason="too-large")


def parse(raw: bytes, place: str, root: str | None = None, max_bytes: int = MAX_BYTES) -> Element:
    """The root element of `raw`, plain or gzipped.

    Raises UnusableInput, naming `place`, for anything that is not well-formed XML, holds a DTD, an entity or an `<include>`, is
    larger than `max_bytes` unpacked or than the other bounds, or has another root element than `root`.
    """
    data = unpack(raw, place, max_bytes)
    _expect_few(data, place)
    try:
        with naming(place):
            element = _tree(data)
    except DefusedXmlException as error:
        raise UnusableInput(f"{place}: the XML holds a DTD or an entity, which is refused", reason="xml-dtd") from error
    except ParseError as error:
        reason = "truncated" if error.code in _CUT_OFF else "not-xml"
        raise UnusableInput(f"{place} is not XML: {error}", reason=reason) from error
    except (UnicodeError, LookupError, ValueError) as error:
        raise UnusableInput(f"{place} is not XML: {error}", reason="not-xml") from error
    if _depth(element) > MAX_DEPTH:
        raise UnusableInput(f"{place} has elements nested more than {MAX_DEPTH} deep", reason="too-large")
    if any(one.tag.rpartition("}")[2] == "include" for one in element.iter()):
        raise UnusableInput(f"{place} includes another file: copy its content to where <include> stands", reason="xml-include")
    if root is not None and element.tag != root:
        raise UnusableInput(f"{place}: the root element is <{element.tag}>, not <{root}>", reason="wrong-root")
    return element


def _tree(data: bytes) -> Element:
    parser: Any = ElementTree.DefusedXMLParser(target=_Tree(), forbid_dtd=True)
    parser.feed(data)
    root: Element = parser.close()
    return root


def unpack(raw: bytes, place: str, max_bytes: int = MAX_BYTES) -> bytes:
    """`raw`, gunzipped if it is gzipped.

    Raises UnusableInput if it is empty, truncated, larger than `max_bytes`, or grows more than `MAX_RATIO` times.
    """
    if not raw:
        raise UnusableInput(f"{place} is empty", reason="empty")
    if raw.startswith(_GZIP):
        max_bytes = min(max_bytes, max(MAX_RATIO * len(raw), _SMALL))
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


def _expect_few(data: bytes, place: str) -> None:
    """Raise UnusableInput where there are more `<` than tags are welcome, or more `=` than attributes.

    In every encoding that expat reads these two are the bytes of ASCII, so no tag and no attribute escapes the count.
    """
    for sign, most, what in ((b"<", MAX_ELEMENTS, "elements"), (b"=", MAX_ATTRIBUTES, "attributes")):
        if data.count(sign) > most:
            raise UnusableInput(f"{place} has more than {most} {what}", reason="too-large")


def _depth(element: Element) -> int:
    depth, level = 0, [element]
    while level and depth <= MAX_DEPTH:
        depth, level = depth + 1, [child for one in level for child in one]
    return depth
