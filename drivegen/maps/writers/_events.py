"""Ramps and weaving sections: what happens along a highway, in words."""

from dataclasses import replace

from drivegen.errors import UnusableInput
from drivegen.maps.writers._facts import EventWords, Facts
from drivegen.maps.writers._phrases import Phrase
from drivegen.maps.writers._places_along import listed_places
from drivegen.maps.writers._quadrants import FORMS, loops_of
from drivegen.maps.writers._sentence import Sentence

_MOST = 9
_ORDINALS = {"second": 2, "third": 3, "fourth": 4, "fifth": 5}
_NAMES = {"on_ramp": "on-ramp", "off_ramp": "off-ramp"}


def read_ramps(s: Sentence, facts: Facts) -> None:
    """Fill in the events along a highway."""
    for phrase in (*s.denied("ramp"), *s.denied("weaving")):
        s.use(phrase.first, phrase.head, "no ramps")
    for phrase in s.said("weaving"):
        facts.features.setdefault("weaving", phrase.first)
        s.use(phrase.head, phrase.head, "weaving section")
    for phrase in s.said("ramp"):
        _read_ramp(s, facts, phrase)
    for phrase in s.said("auxiliary"):
        _read_auxiliary(s, facts, phrase)
    if not facts.interchange:
        _read_verbs(s, facts)
    _read_kept_lanes(s, facts)
    for phrase in s.said("ramp"):  # where a ramp lies that was read by its lane
        own = [e for e in facts.events if e.kind == f"{phrase.value.split('_')[0]}_ramp"]
        if len(own) == 1 and own[0].position is None and own[0].gap is None:
            own[0].position, own[0].gap = phrase.position, phrase.gap
    facts.events.sort(key=lambda event: event.at)
    _leave_ramp_alone(s, facts)
    _refuse_loop_on_highway(s, facts)


def _refuse_loop_on_highway(s: Sentence, facts: Facts) -> None:
    """Raise UnusableInput at a loop ramp and what lies along its motorway: "an exit onto a loop ramp", "a loop on-ramp"."""
    loops = loops_of(s)
    if loops and facts.interchange not in FORMS and (facts.events or any(p not in loops for p in s.said("ramp"))):
        raise UnusableInput(
            "I do not understand what this loop ramp joins: name its motorway, or say that it is alone", reason="not-understood"
        )


def _leave_ramp_alone(s: Sentence, facts: Facts) -> None:
    """Where nothing but a bent ramp is spoken of, it is a one-way road: "a one-lane slip road that bends 90 degrees"."""
    ramps, bent = list(s.said("ramp")), any(s.said("shape", "curve", "s_curve", "hairpin"))
    others = any(s.said("road")) or any(s.said("auxiliary")) or any(s.said("weaving")) or facts.junctions or facts.has("highway")
    if bent and not others and len(ramps) == 1 and len(facts.events) == 1 and s.phrases[0] is ramps[0]:
        facts.events.clear()
        facts.features.setdefault("road", ramps[0].first)
        facts.one_way.append(ramps[0].first)
        if "ramp" in facts.lanes:
            facts.lanes.setdefault("main", facts.lanes.pop("ramp"))
        if "ramp" in facts.speeds:
            facts.speeds.setdefault("main", facts.speeds.pop("ramp"))


def _read_kept_lanes(s: Sentence, facts: Facts) -> None:
    """Ramps whose lanes are the road's own: "exit only", "the ramp's lane goes on as a third lane"."""
    for i in s.of_kind("keeps"):
        kind = f"{s.tokens[i].value}_ramp"
        ramps = [event for event in facts.events if event.kind == kind]
        if not ramps:
            ramps = [EventWords(kind, i)]
            facts.events += ramps
        ramps[-1].keeps = True
        nth = next((n for word, n in _ORDINALS.items() if word in s.tokens[i].text.split()), None)
        if kind == "on_ramp" and nth and not facts.lanes.get("main") and not facts.other_lanes:
            facts.lanes["main"] = nth - 1  # "goes on as the third lane of the motorway"
        s.use(i, i, f"{_NAMES[kind]} with a lane of the road")
    before = facts.from_lanes or facts.lanes.get("main") or 0
    kept = [event for event in facts.events if event.keeps]
    if len(kept) == 1 and facts.to_lanes is not None and before:  # "and goes on with two"
        change = before - facts.to_lanes if kept[0].kind == "off_ramp" else facts.to_lanes - before
        if change == (kept[0].lanes or facts.lanes.get("ramp") or 1):
            facts.lanes["main"], facts.from_lanes, facts.to_lanes = before, None, None
            for name in ("lane_drop", "lane_gain", "lane_change"):
                facts.features.pop(name, None)


def _is_fast(s: Sentence, facts: Facts) -> bool:
    beside = any(s.said("auxiliary")) or any(True for _ in s.of_kind("lane", "main"))
    return beside or facts.has("highway", "divided") or any(p.value in ("on", "off", "") for p in s.said("ramp"))


def _read_ramp(s: Sentence, facts: Facts, phrase: Phrase) -> None:
    if phrase.head in s.used:
        return
    if phrase.value.endswith("_or_arm") and (facts.junctions or not _is_fast(s, facts) or _named_otherwise(s, phrase)):
        return
    if phrase.text.startswith("diverge") and any(p is not phrase and p.value == "off" for p in s.said("ramp")):
        s.use(phrase.head, phrase.head, "")  # "diverge section, one-lane off-ramp": one exit
        return
    kind = "on_ramp" if phrase.value.startswith("on") else "off_ramp" if phrase.value.startswith("off") else _direction(s, phrase)
    s.use(phrase.head, phrase.head, _NAMES[kind])
    known = [event for event in facts.events if event.kind == kind or phrase.value == ""]
    placed_later = phrase.det == "" and phrase.position is not None and not phrase.number  # "an exit ...: exit at 400 m"
    if known and (_refers_back(s, phrase) or (placed_later and known[-1].position is None and known[-1].gap is None)):
        known[-1].lanes = known[-1].lanes or phrase.lanes
        known[-1].speed = known[-1].speed or phrase.speed
        known[-1].gap = known[-1].gap or phrase.gap
        known[-1].position = known[-1].position or phrase.position
        return
    copies = min(phrase.number or 1, _MOST)
    if copies > 1 and s.word(phrase.first - 1, "prep") and s.tokens[phrase.first - 1].text in ("into", "in to"):
        raise UnusableInput("I cannot draw ramps that split into several", reason="not-understood")
    if phrase.number:
        s.use(phrase.first, phrase.head, f"{copies} {_NAMES[kind]}{'s' if copies > 1 else ''}")
    _add_ramps(s, facts, phrase, kind, copies)


def _add_ramps(s: Sentence, facts: Facts, phrase: Phrase, kind: str, copies: int) -> None:
    """New ramps: one of each kind for plain "ramps", one per place that is told, else as many as counted."""
    if phrase.text.endswith("ramps") and phrase.value == "" and not phrase.number:
        if any(p.value and p.head > phrase.head for p in s.said("ramp")):
            return  # "successive ramps: an entry, then another entry"
        facts.events += [EventWords(both, phrase.first + j) for j, both in enumerate(("on_ramp", "off_ramp"))]
        return
    places = listed_places(s, phrase)
    if len(places) > 1 and phrase.number in (None, len(places)):
        facts.events += [EventWords(kind, phrase.first, phrase.lanes, position=metres, speed=phrase.speed) for metres in places]
        if facts.lengths.get("length") in places:
            del facts.lengths["length"]
        return
    event = EventWords(kind, phrase.first, phrase.lanes, position=phrase.position, gap=phrase.gap, speed=phrase.speed)
    each = {int(p.value): p for p in s.said("ordinal") if p.position or p.gap}  # "the first after 400 m, the second ..."
    for k in range(1, copies + 1):
        own = each.get(k) if copies > 1 else None
        facts.events.append(replace(event, position=own.position, gap=own.gap) if own is not None else replace(event))
    if _both_kinds(s, phrase):
        facts.events.append(EventWords("off_ramp" if kind == "on_ramp" else "on_ramp", phrase.first - 1))


def _named_otherwise(s: Sentence, phrase: Phrase) -> bool:
    """Whether a plain "exit" is the "off-ramp" of the same description."""
    return not phrase.number and any(p.value == phrase.value.split("_")[0] for p in s.said("ramp"))


def _both_kinds(s: Sentence, phrase: Phrase) -> bool:
    """ "On and off ramps": the first word has lost its noun."""
    before = [t.text for t in s.tokens[max(0, phrase.first - 3) : phrase.first]]
    wanted = ("on", "entry", "entrance") if phrase.value.startswith("off") else ("off", "exit")
    return len(before) >= 2 and before[-1] in ("and", "then") and before[-2] in wanted


def _refers_back(s: Sentence, phrase: Phrase) -> bool:
    near = s.tokens[max(0, phrase.first - 1) : phrase.head + 1]
    if phrase.head in _heads_of_speeds(s):
        return True  # "exit speed 60 km/h"
    if phrase.text == "ramp" and (s.word(phrase.head + 1, "speed_word") or s.word(phrase.head + 1, "speed")):
        return True  # "ramp speed 60 km/h"
    bare = phrase.value == "" and phrase.det == "" and phrase.number in (None, 1) and s.tokens[phrase.head].text == "ramp"
    if bare and not any(t.kind in ("verb", "that") for t in s.tokens[phrase.head + 1 : phrase.head + 3]):
        return True  # "exit: ramp one lane"
    return any(t.text in ("the", "this", "that", "its", "which", "both", "all", "each", "these") for t in near)


def _heads_of_speeds(s: Sentence) -> set[int]:
    """Ramps that are named for their speed alone, after they were spoken of."""
    said = list(s.said("ramp"))
    return {p.head for p in said[1:] if s.word(p.head + 1, "speed_word") and p.first == p.head}


def _direction(s: Sentence, phrase: Phrase) -> str:
    """Whether a plain "ramp" joins or leaves, by the verbs around it."""
    near: list[tuple[int, str]] = []
    for i in s.verbs("leave", "join", "merge"):
        here, there = min(i, phrase.head), max(i, phrase.head)
        if s.between(here, there, "stop"):
            continue
        other = any(p is not phrase and p.kind == "ramp" and here < p.head < there for p in s.phrases)
        distance = there - here + (3 if i < phrase.head else 0) + (20 if other else 0)
        near.append((distance, "off_ramp" if s.tokens[i].value == "leave" else "on_ramp"))
    near += [(abs(p.head - phrase.head) + 2, "off_ramp" if p.value == "off" else "on_ramp") for p in s.said("auxiliary")]
    return min(near)[1] if near else "on_ramp"


def _read_auxiliary(s: Sentence, facts: Facts, phrase: Phrase) -> None:
    """A lane beside the road belongs to its ramp; without one it implies one."""
    if phrase.value == "weave":
        if {"on_ramp", "off_ramp"} <= {event.kind for event in facts.events}:
            facts.features.setdefault("weaving", phrase.first)
        s.use(phrase.head, phrase.head, "auxiliary lane")
        return
    kind = "off_ramp" if phrase.value == "off" else "on_ramp"
    if "merg" in phrase.text and not any(s.said("ramp")) and facts.has("lane_drop", "lane_change", "fork"):
        s.use(phrase.head, phrase.head, "")  # "a merging zone where four lanes become two"
        return
    if not any(event.kind == kind for event in facts.events) and not facts.has("weaving"):
        if any(e.kind.endswith("ramp") for e in facts.events) and kind == "on_ramp":
            s.use(phrase.head, phrase.head, "auxiliary lane")
            return
        facts.events.append(EventWords(kind, phrase.first))
    s.use(phrase.head, phrase.head, _NAMES[kind])


def _read_verbs(s: Sentence, facts: Facts) -> None:
    """Traffic that joins or leaves a highway without a ramp being named."""
    fast = facts.has("highway", "divided")
    for i in (*s.verbs("leave"), *s.verbs("merge"), *s.verbs("join")):
        if i in s.used or s.negated_at(i):
            continue
        kind = "off_ramp" if s.tokens[i].value == "leave" else "on_ramp"
        s.use(i, i, "")
        if not fast or facts.has("lane_drop", "lane_gain", "lane_change", "weaving", "fork") or facts.junctions:
            continue
        if not any(event.kind == kind for event in facts.events) and not facts.events:
            facts.events.append(EventWords(kind, i))
            s.use(i, i, _NAMES[kind])
