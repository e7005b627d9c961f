"""Offline rules (no language model) for the words of traffic: who, how many, where, how fast, and what they do.

The description is cut into tokens with tags from a lexicon; tags are put together into subjects, places, manoeuvres and
measures; clause by clause, each of these is given to the subject it is said of. What no rule takes, and what contradicts what
was said before, stays in the rest, for whoever reads the road.
"""

import re

from drivegen.asked._clauses import attached
from drivegen.asked._languages import vehicle_clauses
from drivegen.asked._measures import densities, measures
from drivegen.asked._places import places
from drivegen.asked._pronouns import resolve
from drivegen.asked._queues import queues
from drivegen.asked._requested import Outcome, requested
from drivegen.asked._said import Role
from drivegen.asked._subjects import subjects
from drivegen.asked._tokens import Tags, tokens
from drivegen.asked._verbs import verbs
from drivegen.asked.reading import Reading
from drivegen.asked.request import TrafficRequest
from drivegen.maps.writers._reading import normalise

READER = "offline rules (no language model)"

_DASH = re.compile(r"(?<!\d)\s[-–]+\s|\s[-–]+\s(?!\d)")
"""A dash between words parts clauses; one between numbers is a range."""


def read(text: str) -> Reading:
    """The traffic that `text` asks for; a text that says nothing of traffic gives an empty request and itself as the rest.

    Raises UnusableInput, reason `impossible-traffic`, for what is understood and cannot be, such as 500 cars.
    """
    clauses, others = vehicle_clauses(text)
    normal = normalise(_DASH.sub(", ", clauses))
    outcome = _read(normal)
    if not outcome.notes:
        return Reading(TrafficRequest(), (), text, READER)
    rest = " , ".join(filter(None, [others, outcome.rest(normal)]))
    return Reading(outcome.request, outcome.notes, rest, READER)


def _read(text: str) -> Outcome:
    """One normalised text in English."""
    tags = Tags(tokens(text))
    said = measures(tags)
    dense, traffic = densities(tags)
    found, kinds = subjects(tags)
    found = sorted([*found, *traffic], key=lambda subject: subject.begin)
    resolve(tags, found)
    said += [*queues(tags), *verbs(tags), *places(tags)]
    found = [subject for subject in found if subject.role is not Role.TARGET or tags.tag(subject.begin) == "EGO"]
    return requested(tags, attached(tags, found, said), dense, kinds)
