"""The phrase table, read from `tables/*.txt`: what every phrase means, and the forms in which it is said.

An entry is `KIND NAME [VALUE] [= SLOTS] [: SCOPE] :: FORM ; FORM ; ...`, continued on indented lines; its first form is spoken.
thing: VALUE is what its name says of it, SLOTS the fields that the slots of its forms fill.
fact, pre (only before its noun), post (never there): VALUE is that of a fact without slots; SCOPE the things that can hold
it, "-" is the whole, the name of a scope stands for its words.
place: where vehicles stand as seen from the target, alone and behind a distance. link: how two things are related.
cannot: what neither a specification nor the simulator can hold. silent: says nothing, as a whole only. macro: `<name>` in forms.
words: words that say nothing, and others that are told apart.
"""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any, Literal

from drivegen.words.tokens import stems

Kind = Literal["thing", "fact", "link", "cannot", "silent", "word"]


@dataclass(frozen=True, eq=False)
class Phrase:
    """One entry of the table: what it means, and the forms in which it is said, the first of which is spoken.

    Attributes:
        kind: "word" is no entry. name: of the thing, or the field that the fact is about.
        forms: see `forms.py`. value: of a fact without slots; with slots their value, or their values.
        scope: names of the things that can hold the fact; "" is the whole.
        facts: what a thing's own name says of it. slots: fields that the slots of a thing's forms fill.
        place: "pre": only before the noun that it belongs to ("two-lane"); "post": never there; "": either.
    """

    kind: Kind
    name: str
    forms: tuple[str, ...]
    value: Any = None
    scope: tuple[str, ...] = ()
    facts: dict[str, Any] = field(default_factory=dict)
    slots: tuple[str, ...] = ()
    place: Literal["", "pre", "post"] = ""


WORD = Phrase("word", "", ())
"""Stands for a word or mark that no phrase holds."""

_HEAD = re.compile(
    r"(?P<kind>\w+) (?P<name>[^\[{\":=]+?)(?: (?P<value>[\[{\"\d].*?|true|false))?(?: = (?P<slots>[\w ]+))?(?: : (?P<scope>.+))?"
)
_PLACES = {"pre": "pre", "post": "post", "fact": ""}


def _entries(name: str) -> Iterator[tuple[re.Match[str], str]]:
    """The entries of a file: head and body. One that speaks of a SIDE stands for two, of the left and of the right."""
    text = (files("drivegen.words") / "tables" / f"{name}.txt").read_text(encoding="utf-8")
    for entry in text.replace("\n  ", " ").splitlines():
        for side in ("left", "right") if "SIDE" in entry else ("",):
            head, _, body = entry.replace("SIDE", side).partition(" :: ")
            match = _HEAD.fullmatch(head.strip())
            if match is None:
                raise ValueError(f"tables/{name}.txt: {head!r} is no head of an entry")
            yield match, body.strip()


@cache
def words(name: str) -> frozenset[str]:
    """A set of words of words.txt, without the "s" of plurals."""
    return stems(next(body for head, body in _entries("words") if head["name"] == name))


def silent() -> frozenset[str]:
    """The words that say nothing. No number, unit, side, scope, direction or event is among them."""
    return words("determiners") | words("prepositions") | words("verbs") | words("epithets") | words("silent")


@cache
def macros(kind: str = "macro") -> dict[str, str]:
    """The macros of forms, or the names of scopes, each with what it stands for."""
    return {head["name"]: body for head, body in _entries("macros") if head["kind"] == kind}


@cache
def table(name: str) -> tuple[Phrase, ...]:
    """The phrases of one file: roads, lines, traffic, edits, cannot."""
    return tuple(phrase for head, body in _entries(name) for phrase in _phrases(head, body))


def _phrases(head: re.Match[str], body: str) -> tuple[Phrase, ...]:
    if head["kind"] != "place":
        return (_phrase(head, tuple(form.strip() for form in body.split(" ; "))),)
    holders, name = tuple(macros("scope")["VEHICLES"].split()), head["name"]
    near = (f"{body} <me>", f"<being> {body} <me>")
    far = (f"{{length}} {body} <me>", f"<about> {{length}} {body} <me>", f"{body} <me> at <about> {{length}}")
    both = ((near, "place", name), (far, f"far_{name}", None))
    return tuple(Phrase("fact", of, forms, value, holders, place="post") for forms, of, value in both)


def _phrase(head: re.Match[str], forms: tuple[str, ...]) -> Phrase:
    kind, value = head["kind"], None if head["value"] is None else json.loads(head["value"])
    if kind == "thing":
        return Phrase("thing", head["name"], forms, facts=value or {}, slots=tuple((head["slots"] or "").split()))
    if kind in ("link", "cannot", "silent"):
        return Phrase(kind, head["name"], forms)  # type: ignore[arg-type]
    scope = " ".join(macros("scope").get(word, word) for word in (head["scope"] or "").split())
    holders = tuple("" if holder == "-" else holder for holder in scope.split())
    return Phrase("fact", head["name"], forms, value=value, scope=holders, place=_PLACES[kind])  # type: ignore[arg-type]


@cache
def absent() -> tuple[Phrase, ...]:
    """Things that cannot be, said not to be there, which is so."""
    return tuple(
        Phrase("silent", phrase.name, tuple(f"<no> {form}" for form in phrase.forms))
        for phrase in table("cannot")
        if not any(hard in phrase.name for hard in ("turn bans", "hundred", "2+1", "red light", "on the left"))
    )


def traffic_names() -> frozenset[str]:
    """Things that the road reader never sees."""
    return frozenset(phrase.name for phrase in table("traffic") if phrase.kind == "thing")
