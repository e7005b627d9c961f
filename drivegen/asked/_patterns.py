"""Words of traffic, as patterns over normalised English (see `maps.writers._reading`): lower case, digits, one-word units."""

from drivegen.asked.request import Density, Kind, Manoeuvre
from drivegen.assets.where import Relation

TARGET = (
    r"(?:(?:the|our|my|a) )?(?:(?:target|ego|subject|hero|tested)(?: (?:vehicle|car|truck|bus))?|self driving (?:vehicle|car)|"
    r"own (?:vehicle|car)|(?<=our )(?:car|vehicle)|(?<=my )(?:car|vehicle))|us|me"
)
KINDS = {
    Kind.CAR: r"(?:passenger )?cars?|sedans?|suvs?|taxis?|automobiles?|hatchbacks?|vans?|minivans?|pickups?",
    Kind.TRUCK: r"(?:semi ?|heavy |delivery )?trucks?|lorr(?:y|ies)|hgvs?|semis?|articulated lorr(?:y|ies)|trailers?",
    Kind.BUS: r"bus(?:es)?|coach(?:es)?|city bus(?:es)?",
    Kind.VEHICLE: r"vehicles?|leaders?|followers?|tailgaters?|others?|somebody|someone"
    r"|1(?= (?:on|to) (?:the|our|its) (?:left|right))|1 of (?:them|these|the \w+)|one of (?:them|these|the \w+)",
}
NOT_VEHICLES = r"(?! ?(?:lanes?|stops?|stations?|parks?|parking|wash|bays?|depots?|dealers?|ferr\w+|only|traffic))"
"""A noun before these is part of a road: "bus lane", "car park"."""

COUNT = r"\d+|an?|another|several|some|a few|few|many|the|its|any"
NUMBERS = {"several": 4, "some": 3, "a few": 3, "few": 3, "many": 10}
"""What numbers in words are taken for."""

ADJECTIVES = (
    r"oncoming|opposing|stopped|stationary|parked|standing|stalled|broken down|immobile|slow(?:er)?(?: moving)?|fast(?:er)?|"
    r"lead|leading|front|preceding|rear|following|trailing|overtaking|passing|merging|big|large|small|heavy|other|more|"
    r"additional|further|social|background|surrounding|neighbou?ring|crossing|queued|queueing|waiting|left turning|"
    r"sports|right turning|cutting in|braking|moving|single|aggressive|double parked"
)
QUEUE_OF = r"(?:a |an |1 |the )?(?:queue|line|column|row|convoy|platoon|string|file)(?: of| with)"

_OF_TARGET = rf"(?: (?:of|to|from|by|with)? ?(?:{TARGET}))?"
_BY = r"(?:(?:in|on|to|of|at|into) )?(?:the |its |our )?"
_AT_SIDE = r"(?:in|on|to|from) (?:the |its |our |my )?(?:lane (?:to|on) the )?"

# The more special come first: what matches takes its words.
PLACES = (
    (Relation.LEFT_AHEAD, rf"(?:ahead|in front),? (?:and )?{_BY}left(?: hand)?(?: lane| side)?|{_BY}left lane ahead{_OF_TARGET}"),
    (
        Relation.RIGHT_AHEAD,
        rf"(?:ahead|in front),? (?:and )?{_BY}right(?: hand)?(?: lane| side)?|{_BY}right lane ahead{_OF_TARGET}",
    ),
    (Relation.LEFT_BEHIND, rf"behind,? (?:and )?{_BY}left(?: hand)?(?: lane| side)?|{_BY}left lane behind{_OF_TARGET}"),
    (Relation.RIGHT_BEHIND, rf"behind,? (?:and )?{_BY}right(?: hand)?(?: lane| side)?|{_BY}right lane behind{_OF_TARGET}"),
    (
        Relation.ONCOMING,
        r"oncoming|opposing|(?:coming |driving |approaching )?(?:from|in) the (?:opposite|other|oncoming) (?:direction|lane)"
        rf"|(?:coming|driving) towards? (?:{TARGET})|(?:coming |approaching )from (?:the )?front|head on",
    ),
    (Relation.FROM_LEFT, r"(?:coming|approaching|crossing|arriving|entering)(?: in)? from (?:the |its )?left(?: side)?"),
    (Relation.FROM_RIGHT, r"(?:coming|approaching|crossing|arriving|entering)(?: in)? from (?:the |its )?right(?: side)?"),
    (Relation.LEFT, rf"{_AT_SIDE}left(?: hand)?(?: lane| side)?{_OF_TARGET}"),
    (Relation.RIGHT, rf"{_AT_SIDE}right(?: hand)?(?: lane| side)?{_OF_TARGET}"),
    (
        Relation.AHEAD,
        rf"(?:that |which )?(?:we are|(?:{TARGET}) is) (?:following|behind|tailing)"
        rf"|(?:in|on|blocking|obstructing) (?:our|my|the (?:target|ego)(?: vehicle)?s?) (?:lane|way|path)",
    ),
    (Relation.AHEAD, rf"(?:directly |straight |right |just )?(?:ahead|in front|before(?= {TARGET}))(?: of)?(?: (?:{TARGET}))?"),
    (Relation.BEHIND, rf"(?:directly |right |just |close )?(?:behind|tailgating|following)(?: (?:{TARGET}))?"),
    (Relation.LEFT, rf"(?:alongside|beside|next to|abreast(?: of)?)(?: (?:{TARGET}))?"),
)
ADJECTIVE_PLACES = {
    "lead": Relation.AHEAD, "leading": Relation.AHEAD, "front": Relation.AHEAD, "preceding": Relation.AHEAD,
    "rear": Relation.BEHIND, "following": Relation.BEHIND, "trailing": Relation.BEHIND, "oncoming": Relation.ONCOMING,
    "opposing": Relation.ONCOMING,
}  # fmt: skip
ADJECTIVE_MANOEUVRES = {
    "overtaking": Manoeuvre.OVERTAKE, "passing": Manoeuvre.OVERTAKE, "cutting in": Manoeuvre.CUT_IN,
    "left turning": Manoeuvre.TURN_LEFT, "right turning": Manoeuvre.TURN_RIGHT, "stopped": Manoeuvre.STOPPED,
    "stationary": Manoeuvre.STOPPED, "parked": Manoeuvre.STOPPED, "standing": Manoeuvre.STOPPED, "stalled": Manoeuvre.STOPPED,
    "broken down": Manoeuvre.STOPPED, "immobile": Manoeuvre.STOPPED,
}  # fmt: skip
NOUN_PLACES = {"leader": Relation.AHEAD, "follower": Relation.BEHIND, "tailgater": Relation.BEHIND}

_SIDE = r"(?:in ?to |to |towards? )?(?:the |its |our )?"
_J = r"the (?:crossing|junction|intersection)"
_GOES = r"(?:turn(?:s|ing)?|go(?:es|ing)?|(?:mak|tak)(?:es?|ing) an?)(?: off)?(?: to the)?"
_CHANGES = r"(?:chang|switch|mov|merg|drift|shift|slid|steer)\w*(?: (?:1 |a )?lanes?)?(?: over)?"
MANOEUVRES = (
    (
        Manoeuvre.CUT_IN,
        rf"cut(?:s|ting)?(?: \w+ly)?(?: (?:{TARGET}))? (?:in(?:to (?:the|our|its) lane)?|off)"
        rf"(?: (?:in front of|before|ahead of))?(?: (?:{TARGET}))?"
        rf"|(?:merg|pull|swerv|squeez|mov|chang|switch|veer)\w*(?: \w+ly)?(?: lanes?)?(?: in| over| out)?"
        rf"(?: just| right| directly)? (?:in front of|ahead of|before|in ?to the lane of)(?: (?:{TARGET}))",
    ),
    (
        Manoeuvre.HARD_BRAKING,
        r"brak(?:es?|ing)(?: (?:very|extremely|so))? (?:hard|sharply|suddenly|heavily|abruptly|violently)(?: to a (?:stop|halt))?"
        r"|(?:suddenly|sharply|abruptly|hard) brak(?:es?|ing)|(?:hard|sudden|sharp|heavy|emergency|full|panic|abrupt) brak\w+"
        r"|(?:emergency|panic|sudden|abrupt) stops?"
        r"|(?:slam|stamp|stomp|jump|step)\w* (?:hard )?(?:on )?(?:the |its )?brakes?(?: on)?"
        r"|(?:suddenly|abruptly) stop(?:s|ping)|stop(?:s|ping) (?:suddenly|abruptly)",
    ),
    (
        Manoeuvre.STOPPED,
        r"(?:is |has |which is |that is )?(?:stopped|stationary|double parked|parked|stalled|broken down|immobile"
        r"|standing(?: still)?|at a standstill)|breaks? down",
    ),
    (
        Manoeuvre.OVERTAKE,
        rf"(?:overtak(?:es?|ing)|pass(?:es|ing))(?: (?:{TARGET}))?(?: (?:on|from) the (?:left|right))?"
        rf"|(?:speed|rac|driv|zoom|shoot|rush|sweep|go)\w* past(?: (?:{TARGET}))?(?: (?:on|from) the (?:left|right))?"
        rf"|undertak(?:es?|ing)(?: (?:{TARGET}))?",
    ),
    (
        Manoeuvre.TURN_LEFT_ACROSS,
        rf"{_GOES} left(?: turn)? (?:across|in front of|through)(?: \w+){{0,3}}? (?:path|way|lane|target|ego|us)(?: at {_J})?",
    ),
    (
        Manoeuvre.TURN_LEFT,
        rf"{_GOES} left(?: turn)?(?! lane)(?: at {_J})?|left turning",
    ),
    (
        Manoeuvre.TURN_RIGHT,
        rf"{_GOES} right(?: turn)?(?! lane)(?: at {_J})?|right turning",
    ),
    (
        Manoeuvre.CHANGE_LEFT,
        rf"{_CHANGES} {_SIDE}left(?: lane)?|(?:makes? )?(?:a )?left lane change"
        r"|(?:makes? )?(?:a )?lane change to the left",
    ),
    (
        Manoeuvre.CHANGE_RIGHT,
        rf"{_CHANGES} {_SIDE}right(?: lane)?"
        r"|(?:makes? )?(?:a )?right lane change|(?:makes? )?(?:a )?lane change to the right",
    ),
)
EVENTS = (
    r"(?:an? |1 |another )?(?:sudden |late |sharp |aggressive )?cut in|(?:an? |1 )?(?:hard|sudden|emergency|full|panic|heavy) "
    r"(?:brak(?:ing|e)(?: manoeuvre| maneuver)?|stop)"
)
"""Manoeuvres that are named without naming who does them."""

QUEUED = (
    r"(?:running |driving |moving |standing |waiting )?in (?:a |single )?(?:queue|line|file|convoy|column|platoon|row)"
    r"|queue(?:d|ing)?(?: up)?|lined up|bumper[ -]to[ -]bumper(?! traffic)"
    r"|one behind (?:another|the other)|1 behind (?:another|the other)"
)
AROUND = rf"(?:all )?(?:around|near|nearby|close to|surrounding|in the vicinity of|about)(?: (?:{TARGET}))|nearby|surrounding"
SECONDS = (
    r"(?:(?:with)?in|after|during|at|no later than|before)(?: (?:the|less|than|about|around|first|next|only|just|under|at|most))*"
    r" (\d+(?:\.\d+)?) ?(?:s|secs?|seconds?)(?: from now| later)?"
)
DISTANCE = r"(?:(?:about|around|roughly|only|some|at|by|of) )*(\d+(?:\.\d+)?) ?(m|ft|yd)(?: away| long)?"
LENGTHS = {"m": 1.0, "ft": 0.3048, "yd": 0.9144}
SPEED = (
    r"(?:(?:all|driving|moving|travell?ing|going|flowing|at|with|a|speeds?|of|about|around|roughly|approximately|doing|drive|drives"
    r"|move|moves|travel|travels|everybody|everyone) )*(\d+(?:\.\d+)?) ?(kmh|mph|mps)"
)
SPEEDS = {"kmh": 1 / 3.6, "mph": 0.44704, "mps": 1.0}
ROAD_WORDS = (
    r"\b(?:limit\w*|zones?|signed|posted|roads?|streets?|highways?|motorways?|freeways?|lanes?|crossings?|intersections?|junctions?|"
    r"roundabouts?|ramps?|curves?|bends?|arterials?|avenues?|expressways?|crossroads|arms?)\b"
)
"""A speed in a clause with one of these, and no vehicle, is the road's."""

DENSITIES = (
    (
        Density.DENSE,
        r"(?:with |in |very )*(?:dense|heavy|busy|congested|rush hour|crowded|thick|packed)(?: road)? traffic"
        r"|traffic (?:is |being )?(?:very )?(?:dense|heavy|busy|congested)|(?:very )?dense(?:ly packed)?|traffic jam|jammed"
        r"|bumper[ -]to[ -]bumper traffic"
        r"|closely packed|tightly packed",
    ),
    (Density.MEDIUM, r"(?:with |in )*(?:medium|moderate|normal|average|ordinary)(?: density)?(?: of)? traffic|medium density"),
    (
        Density.SPARSE,
        r"(?:with |in |very )*(?:sparse|light|thin|little|low)(?: density)?(?: of)? traffic|traffic (?:is |being )?(?:very )?"
        r"(?:sparse|light|thin)|(?:very )?sparse(?:ly)?|(?:hardly any|barely any|scarcely any|almost no|next to no) traffic",
    ),
)
FILLERS = r"sharply|suddenly|slowly|moving|driving|travell?ing|going|approaching|coming|waiting|same|lane|there|traffic"
"""Words that add nothing to what is understood beside a vehicle."""
