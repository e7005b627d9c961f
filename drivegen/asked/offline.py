"""Offline rules (no language model) for the words of traffic: who, how many, where, how fast, and what they do.

A description is cut at its vehicles: each noun with its number begins a phrase that runs to the next one, and what stands in
the phrase is said of that vehicle. What no rule takes stays in the rest, for whoever reads the road.
"""

import itertools
import re
from dataclasses import dataclass, field
from typing import Any

from pydantic import ValidationError

from drivegen.asked import _patterns as words
from drivegen.asked._languages import vehicle_clauses
from drivegen.asked.reading import Reading
from drivegen.asked.request import Density, Group, Kind, Manoeuvre, TrafficRequest
from drivegen.assets.where import Relation
from drivegen.errors import UnusableInput
from drivegen.maps.writers._reading import Reading as Text

READER = "offline rules (no language model)"

_KIND = "|".join(rf"(?P<{kind.name}>{pattern})" for kind, pattern in words.KINDS.items())
_NOUNS = "|".join(words.KINDS.values())
_OBJECT = re.compile(r"\b(?:of|to|from|by|with|around|behind|before|near|at|past|following|towards?|overtak\w+|pass\w+|\w+ing)$")
"""Before these words the target is what others do something to."""

_VEHICLES = (
    rf"(?P<queue>{words.QUEUE_OF} )?(?:(?P<count>{words.COUNT}) )?(?P<adjectives>(?:(?:{words.ADJECTIVES}),? )*)"
    rf"(?:{_KIND}){words.NOT_VEHICLES}"
)
_LEADER = r"(?P<queue>(?!))?(?P<count>the )(?P<adjectives>)(?P<VEHICLE>lead)(?= (?:brak|stop|slam|sudden|hard|is|turn|chang))"


@dataclass
class _Phrase:
    """One vehicle or several, and where what is said of them ends in the text."""

    begin: int
    end: int
    stop: int
    fields: dict[str, Any] = field(default_factory=dict)
    target: bool = False


def read(text: str) -> Reading:
    """The traffic that `text` asks for; a text that says nothing of traffic gives an empty request and itself as the rest.

    Raises UnusableInput, reason `impossible-traffic`, for what is understood and cannot be, such as 500 cars.
    """
    clauses, others = vehicle_clauses(text)
    reader = _Reader(Text(clauses))
    request = reader.request()
    if not reader.text.notes:
        return Reading(TrafficRequest(), (), text, READER)
    rest = " , ".join(filter(None, [others, reader.rest()]))
    return Reading(request, tuple(reader.text.notes), rest, READER)


class _Reader:
    """Reads one normalised text; every rule takes its words from it."""

    def __init__(self, text: Text) -> None:
        self.text = text
        self.speed: float | None = None
        self.density: Density | None = None

    def request(self) -> TrafficRequest:
        """Everything that is asked for."""
        phrases = self._phrases()
        for phrase in phrases:
            self._describe(phrase)
        for before, phrase in itertools.pairwise(phrases):
            if self.text.text[phrase.begin : phrase.end] == "1" and not before.target:  # "a car on our left, one on our right"
                phrase.fields["kind"] = before.fields["kind"]
        self._density()
        self._speed_of_all(bool(phrases))
        target = {name: value for p in reversed(phrases) if p.target for name, value in p.fields.items()}
        groups = [self._group(p.fields) for p in phrases if not p.target]
        try:
            return TrafficRequest(
                groups=tuple(groups),
                density=self.density,
                speed=target.get("speed", self.speed),
                target_kind=target.get("kind"),
                target_does=target.get("manoeuvre"),
            )
        except ValidationError as error:
            raise UnusableInput(f"this traffic cannot be placed: {_first(error)}", reason="impossible-traffic") from None

    def rest(self) -> str:
        """The text without what was taken."""
        left = self.text.untaken()
        return re.sub(r"(?:\s*,)+", " ,", re.sub(r"\s+", " ", left)).strip(" ,.")

    def _phrases(self) -> list[_Phrase]:
        """Vehicles in the order of the text; each one's phrase ends where the next begins, or with its sentence."""
        targets = list(self.text.all(rf"(?:{words.TARGET})(?= (?:is|turn|chang|driv|brak|mov|mak|tak|go|stop|switch|merg))"))
        found = [phrase for m in targets if (phrase := self._target_phrase(m)) is not None]
        for pattern in (_VEHICLES, _LEADER):
            found += [phrase for m in list(self.text.all(pattern)) if (phrase := self._vehicle_phrase(m)) is not None]
        for match in list(self.text.all(words.EVENTS)):
            said_of = (p for p in found if p.begin <= match.start() and not self._clause_ends(p.end, match.start()))
            if next(said_of, None) is None:
                found.append(_Phrase(match.start(), match.start(), 0, {"kind": Kind.VEHICLE, "count": 1}))
        found.sort(key=lambda phrase: phrase.begin)
        found = self._with_doers(found)
        ends = [phrase.begin for phrase in found[1:]] + [len(self.text.text)]
        for phrase, following in zip(found, ends[: len(found)], strict=True):
            sentence = self.text.text.find(" . ", phrase.end)
            phrase.stop = following if sentence < 0 else min(sentence, following)
        return found

    def _clause_ends(self, begin: int, end: int) -> bool:
        return re.search(r"[.,]", self.text.text[begin:end]) is not None

    def _with_doers(self, found: list[_Phrase]) -> list[_Phrase]:
        """Phrases where "hard braking of the lead vehicle" is said of that vehicle and not of another one."""
        kept: list[_Phrase] = []
        for phrase in found:
            before = kept[-1] if kept else None
            between = self.text.text[before.begin : phrase.begin] if before else ""
            event = re.fullmatch(rf"({words.EVENTS}) (?:of|by|from)(?: the)? ?", between)
            if before is not None and before.begin == before.end and event is not None:
                manoeuvre = next(m for m, pattern in words.MANOEUVRES if re.search(pattern, event[1]))
                phrase.fields["manoeuvre"] = manoeuvre
                if match := self._at(before.begin, words.EVENTS):
                    self.text.take(match, manoeuvre.value.replace("_", " "))
                kept.pop()
            kept.append(phrase)
        return kept

    def _at(self, begin: int, pattern: str) -> re.Match[str] | None:
        return next((m for m in self.text.all(pattern) if m.start() == begin), None)

    def _target_phrase(self, match: re.Match[str]) -> _Phrase | None:
        if _OBJECT.search(self.text.text[: match.start()].rstrip()):
            return None
        self.text.take(match, "the target")
        kinds = {kind for kind in (Kind.CAR, Kind.TRUCK, Kind.BUS) if re.search(rf"\b{kind}\b", match.group())}
        return _Phrase(match.start(), match.end(), 0, {"kind": kinds.pop()} if kinds else {}, target=True)

    def _vehicle_phrase(self, match: re.Match[str]) -> _Phrase | None:
        if self.text.negated(match) or (match["count"] or "").strip() == "any" or self._of_target(match):
            return None
        kind = next(kind for kind in Kind if kind.name in match.groupdict() and match[kind.name])
        said = (match["count"] or "").strip()
        plural = match[kind.name].endswith("s") and match[kind.name] != "bus"
        count = int(said) if said.isdigit() else words.NUMBERS.get(said, 2 if plural and said in ("", "the") else 1)
        if match.group() in ("other", "others") or (kind is Kind.VEHICLE and match[kind.name].startswith("other") and not said):
            return None
        fields: dict[str, Any] = {"kind": kind, "count": count}
        adjectives = match["adjectives"]
        for word, place in words.ADJECTIVE_PLACES.items():
            if re.search(rf"\b{word}\b", adjectives):
                fields["place"] = place
        for noun, place in words.NOUN_PLACES.items():
            if match[kind.name].startswith(noun):
                fields["place"] = place
        if match[kind.name] == "lead":
            fields["place"] = Relation.AHEAD
        if match["queue"]:
            fields["queue"] = True
        self._from_adjectives(adjectives, fields)
        self.text.take(match, _told(fields))
        return _Phrase(match.start(), match.end(), 0, fields)

    def _of_target(self, match: re.Match[str]) -> bool:
        """Whether the noun is the target's own: "the ego vehicle", "the target is a truck"."""
        spans = (m.span() for m in re.finditer(rf"\b(?:{words.TARGET})\b", self.text.text))
        if any(begin < match.end() and match.start() < end for begin, end in spans):
            return True
        return re.search(rf"\b(?:{words.TARGET}) is(?: driving)?$", self.text.text[: match.start()].rstrip()) is not None

    def _from_adjectives(self, adjectives: str, fields: dict[str, Any]) -> None:
        for word, manoeuvre in words.ADJECTIVE_MANOEUVRES.items():
            if word in adjectives:
                fields["manoeuvre"] = manoeuvre
        if "queue" in adjectives:
            fields["queue"] = True

    def _describe(self, phrase: _Phrase) -> None:
        """What the words of a phrase say of its vehicles."""
        for manoeuvre, pattern in words.MANOEUVRES:
            match = self._in(phrase, pattern)
            if match is not None and "manoeuvre" not in phrase.fields:
                phrase.fields["manoeuvre"] = manoeuvre
                if manoeuvre is Manoeuvre.OVERTAKE and "right" in match.group():
                    phrase.fields["place"] = Relation.RIGHT_BEHIND
                self.text.take(match, manoeuvre.value.replace("_", " "))
        if phrase.target:
            self._target_is(phrase)
        else:
            self._where(phrase)
        if (match := self._in(phrase, words.SECONDS)) is not None and "manoeuvre" in phrase.fields:
            phrase.fields["within"] = float(match[1])
            self.text.take(match, f"within {match[1]} s")
        self._own_speed(phrase)
        for pattern in (words.AROUND, words.FILLERS):
            while (match := self._in(phrase, pattern, same_clause=True)) is not None:
                self.text.take(match, "")

    def _target_is(self, phrase: _Phrase) -> None:
        if match := self._in(phrase, r"is an? (car|truck|bus|lorry)", same_clause=True):
            phrase.fields["kind"] = Kind.TRUCK if match[1] == "lorry" else Kind(match[1])
            self.text.take(match, f"the target is a {phrase.fields['kind']}")

    def _where(self, phrase: _Phrase) -> None:
        if (match := self._in(phrase, words.QUEUED)) is not None:
            phrase.fields["queue"] = True
            self.text.take(match, "in a queue")
        for place, pattern in words.PLACES:
            match = self._in(phrase, pattern)
            if match is not None and ("place" not in phrase.fields or phrase.fields["place"] is place):
                phrase.fields["place"] = place
                self.text.take(match, place.value.replace("_", " "))
        distance = self._in(phrase, words.DISTANCE, same_clause=True)
        if distance is not None and ("place" in phrase.fields or "manoeuvre" in phrase.fields):
            phrase.fields["distance"] = round(float(distance[1]) * words.LENGTHS[distance[2]], 2)
            self.text.take(distance, f"{distance[1]} {distance[2]} away")

    def _own_speed(self, phrase: _Phrase) -> None:
        """A speed right beside a vehicle that is told apart is its own."""
        apart = phrase.target or any(name in phrase.fields for name in ("place", "manoeuvre", "queue"))
        if apart and (match := self._in(phrase, words.SPEED, same_clause=True)) is not None:
            phrase.fields["speed"] = float(match[1]) * words.SPEEDS[match[2]]
            self.text.take(match, f"speed {match[1]} {match[2]}")

    def _speed_of_all(self, vehicles: bool) -> None:
        """A speed in a clause about vehicles, or in one of its own after vehicles, is everybody's."""
        for match in list(self.text.all(words.SPEED)):
            before, after = self.text.text[: match.start()], self.text.text[match.end() :]
            clause = re.split(r"[.,]", before)[-1] + match.group() + re.split(r"[.,]", after)[0]
            about = re.search(rf"\b(?:{_NOUNS}|traffic|driv\w+|mov\w+|travel\w*|speeds? (?:of|about|around))\b", clause)
            follows = vehicles and _after_vehicle(before)
            if "limit" in clause or not (about or (follows and not re.search(words.ROAD_WORDS, clause))):
                continue
            self.speed = float(match[1]) * words.SPEEDS[match[2]]
            self.text.take(match, f"all at about {match[1]} {match[2]}")

    def _density(self) -> None:
        for density, pattern in words.DENSITIES:
            for match in list(self.text.all(pattern)):
                self.density = density
                self.text.take(match, f"{density.value} traffic")

    def _in(self, phrase: _Phrase, pattern: str, *, same_clause: bool = False) -> re.Match[str] | None:
        stop = phrase.stop
        if same_clause:
            comma = self.text.text.find(" , ", phrase.end)
            stop = min(stop, comma if comma >= 0 else stop)
        return next((m for m in self.text.all(pattern) if m.start() >= phrase.end and m.end() <= stop), None)

    @staticmethod
    def _group(fields: dict[str, Any]) -> Group:
        oncoming = fields.get("place") is Relation.ONCOMING
        if fields.get("manoeuvre") is Manoeuvre.TURN_LEFT and oncoming:
            fields = {**fields, "manoeuvre": Manoeuvre.TURN_LEFT_ACROSS}
        try:
            return Group(**fields)
        except ValidationError as error:
            raise UnusableInput(f"this traffic cannot be placed: {_first(error)}", reason="impossible-traffic") from None


def _after_vehicle(before: str) -> bool:
    """Whether the last clauses before are about vehicles rather than about the road."""
    for clause in reversed(re.split(r"[.,]", before)):
        if re.search(rf"\b(?:{_NOUNS}|traffic|{words.TARGET})\b", clause):
            return True
        if re.search(words.ROAD_WORDS, clause):
            return False
    return False


def _told(fields: dict[str, Any]) -> str:
    count, kind = fields["count"], fields["kind"].value
    said = [f"{count} {kind}{'' if count == 1 else 'es' if kind == 'bus' else 's'}"]
    said += [str(fields[name].value).replace("_", " ") for name in ("place", "manoeuvre") if name in fields]
    return ", ".join([*said, "in a queue"] if fields.get("queue") else said)


def _first(error: ValidationError) -> str:
    """The first complaint, without pydantic's words around it."""
    detail = error.errors(include_url=False)[0]
    place = " ".join(str(part) for part in detail["loc"] if not isinstance(part, int)).replace("_", " ")
    message = detail["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    return f"{place} {message}".strip()
