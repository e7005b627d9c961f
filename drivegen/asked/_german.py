"""German words of traffic, phrase by phrase in English."""

import re

_NUMBERS = {
    "zwei": 2, "drei": 3, "vier": 4, "fünf": 5, "sechs": 6, "sieben": 7, "acht": 8, "neun": 9, "zehn": 10, "elf": 11, "zwölf": 12,
    "dreizehn": 13, "vierzehn": 14, "fünfzehn": 15, "sechzehn": 16, "siebzehn": 17, "achtzehn": 18, "neunzehn": 19, "zwanzig": 20,
    "dreißig": 30, "vierzig": 40, "fünfzig": 50,
}  # fmt: skip
_CAR = r"autos?|pkws?|wagen|taxis?|lieferwagen|(?:klein)?transportern?|kombis?|limousinen?|geländewagen|kleinwagen|sportwagen"
_TRUCK = r"lkws?|lastwagen|lastern?|sattelz(?:ug|üge)n?|sattelschleppern?|lastz(?:ug|üge)n?|tanklastern?|müllwagen|lastkraftwagen"
_BUS = r"(?:reise|linien|gelenk|schul|stadt)?bus(?:se|sen|ses)?"
_ANY = r"fahrzeuge?n?s?"
_EGO = (
    r"(?:(?:das|dem|des|den|unser\w*|mein\w*) )?(?:ziel|ego|test)[ -]?(?:fahrzeug|auto|wagen|pkw)e?s?"
    r"|(?:dem|das|der|des|vom) egos?"
    r"|(?:unser\w*|mein\w*|(?:das|dem|des) eigene\w*) (?:fahrzeug|auto|wagen|pkw)e?s?|ego"
)
_WHO = rf"(?:uns|mir|ihm|ihn|{_EGO})"
_ENDS = r"(?= ?(?:$|,|und|während|innerhalb|binnen|von|vor|nach|in|knapp|bei|mit|wobei|aber|\.))"
_HARD = r"(?:sehr |ganz )?(?:stark|scharf|hart|plötzlich|abrupt|voll|heftig|kräftig|ruckartig)"
_LANE = r"(?:fahr)?(?:spur|streifen|bahn)|seite"

SIGN = re.compile(
    rf"\b(?:{_ANY}|{_TRUCK}|autos?|pkws?|busse|bremst|überhol\w*|schert|verkehrs?|sekunden?|entgegen\w+|dichter|biegt|vor uns|"
    r"hinter uns|wir|wechselt|einen|vorausfahrende\w*)\b"
)
VEHICLE = re.compile(rf"\b(?:{_CAR}|{_TRUCK}|{_BUS}|{_ANY}|{_EGO}|wir)\b")
TRAFFIC = re.compile(
    rf"\b(?:{_CAR}|{_TRUCK}|{_BUS}|{_ANY}|{_EGO}|wir|uns|(?:\w+)?verkehr\w*|stau|dicht|bremst|überhol\w*|schert|biegt|vordermann|"
    rf"hintermann|jemand|einer|alle|{_HARD}bremsung|\w*bremsung|kolonne|konvoi|innerhalb|binnen|sekunden?|spurwechsel)\b"
    r"|\d ?km/h|einscher"
)

_PHRASES = (
    (rf"scher(?:t|en) (.*?)\bvor {_WHO} (.*?)\bein\b{_ENDS}", r"\1 \2 cuts in"),
    (rf"scher(?:t|en) (.*?)\bein\b{_ENDS}", r"\1 cuts in"),
    (r"einscher(?:t|en|end\w*)", "cutting in"),
    (rf"(?:zieht|drängt(?: sich)?|drängelt sich|schiebt sich|setzt sich|quetscht sich) (.*?)\bvor {_WHO}(?: hinein| rein| ein)?",
     r"\1 cuts in"),
    (rf"schneidet {_WHO}", "cuts in"),
    (rf"bremst (.*?)\b{_HARD}(?: ab)?\b", r"\1 brakes hard"),
    (r"(?:macht|legt|führt|vollführt) (?:eine )?(?:voll|not|gefahren)bremsung(?: hin| durch)?", "brakes hard"),
    (r"(?:eine )?(?:voll|not|gefahren)bremsung(?: des| der)?", "hard braking of the"),
    (r"(?:steigt|tritt|geht) (?:voll |hart )?(?:auf die bremse|in die eisen|in die bremsen)", "brakes hard"),
    (rf"biegt (.*?)\bvor {_WHO} (?:nach )?links ab", r"\1 turns left across our path"),
    (rf"biegt (.*?)(?:nach )?links (?:vor {_WHO} )ab", r"\1 turns left across our path"),
    (r"biegt (.*?)(?:nach )?links ab", r"\1 turns left"),
    (r"biegt (.*?)(?:nach )?rechts ab", r"\1 turns right"),
    (r"links abbieg\w+", "left turning"), (r"rechts abbieg\w+", "right turning"),
    (rf"(?:wechselt|zieht|fährt) (.*?)\bvor {_WHO} auf unsere (?:{_LANE})", r"\1 moves into our lane"),
    (rf"(?:wechselt|zieht|fährt) (.*?)\bauf unsere (?:{_LANE})", r"\1 moves into our lane"),
    (rf"(?:wechselt|zieht|fährt) (?:nach|auf|in) (?:die |den )?link(?:s|en?)(?: (?:{_LANE}))?", "changes to the left lane"),
    (rf"(?:wechselt|zieht|fährt) (?:nach|auf|in) (?:die |den )?recht(?:s|en?)(?: (?:{_LANE}))?", "changes to the right lane"),
    (r"(?:macht )?(?:einen )?(?:spur|fahrstreifen)wechsel nach links|wechselt (?:die|den) (?:spur|fahrstreifen) nach links",
     "changes to the left lane"),
    (r"(?:macht )?(?:einen )?(?:spur|fahrstreifen)wechsel nach rechts|wechselt (?:die|den) (?:spur|fahrstreifen) nach rechts",
     "changes to the right lane"),
    (r"wird (.*?)von (.*?)überholt", r"\1 is overtaken by \2"),
    (rf"überholt (?:{_WHO} )?(.*?)\blinks", r"\1 overtakes us"),
    (rf"überholt (?:{_WHO} )?(.*?)\brechts", r"\1 overtakes us on the right"),
    (rf"überholt(?: {_WHO})?|fährt an {_WHO} vorbei|zieht an {_WHO} vorbei", "overtakes us"),
    (r"überholende[rsnm]?", "overtaking"),
    (rf"(?:{_WHO} )?entgegen ?komm(?:t|en)", "is oncoming"),
    (rf"kommt {_WHO} (.*?)entgegen|kommen {_WHO} (.*?)entgegen", r"oncoming \1"), (r"entgegenkommende[rsnm]?", "oncoming"),
    (r"(?:aus|in) der gegenrichtung|auf der gegen(?:fahrbahn|spur)|im gegenverkehr|von vorne?", "from the opposite direction"),
    (rf"fährt (?:{_WHO} )?(?:sehr )?(?:dicht|nah) auf|drängelt(?: hinter {_WHO})?|folgt {_WHO}|verfolgt {_WHO}", "tailgates us"),
    (r"(?:die|der|das) (?:wir|das ego\w*) (?:folgen|hinterherfahren|folgt)", "that we follow"),
    (r"(?:kommt|nähert sich|kommend) (?:von|aus) (?:der )?links?(?: her)?", "coming from the left"),
    (r"(?:kommt|nähert sich|kommend) (?:von|aus) (?:der )?rechts?(?: her)?", "coming from the right"),
    (r"aus der (?:linken|von links) (?:seiten|neben|quer)straße", "from the side road on the left"),
    (r"aus der (?:rechten|von rechts) (?:seiten|neben|quer)straße", "from the side road on the right"),
    (rf"(?:schräg )?links vor {_WHO}", "ahead of us on the left"),
    (rf"(?:schräg )?rechts vor {_WHO}", "ahead of us on the right"),
    (rf"(?:schräg )?links hinter {_WHO}", "behind us on the left"),
    (rf"(?:schräg )?rechts hinter {_WHO}", "behind us on the right"),
    (rf"links (?:neben|von) {_WHO}|zu unserer linken|links daneben", "on the left of us"),
    (rf"rechts (?:neben|von) {_WHO}|zu unserer rechten|rechts daneben", "on the right of us"),
    (rf"(?:von|aus) (?:der |dem )?linken (?:{_LANE})", "from the left lane"),
    (rf"(?:von|aus) (?:der |dem )?rechten (?:{_LANE})", "from the right lane"),
    (rf"(?:auf|in|im) (?:der |dem )?linken (?:{_LANE})", "in the left lane"),
    (rf"(?:auf|in|im) (?:der |dem )?rechten (?:{_LANE})", "in the right lane"),
    (rf"(?:auf|in) unser\w* (?:{_LANE})|im weg|vor unserer nase", "in our lane"),
    (rf"(?:dicht |direkt |knapp |kurz )?vor {_WHO}", "ahead of us"),
    (rf"(?:dicht |direkt |knapp |kurz )?hinter {_WHO}", "behind us"),
    (rf"neben {_WHO}", "beside us"),
    (r"von (?:der )?rechts?", "from the right"), (r"von (?:der )?links?", "from the left"), (r"von hinten", "from behind"),
    (r"(?:eine |einer |ein |einem )?(?:kolonne|schlange|reihe|konvoi|kette) (?:von|aus|mit)", "a queue of"),
    (r"(?:in|im) (?:einer |einem )?(?:kolonne|schlange|reihe|konvoi)|hintereinander", "in a queue"),
    (r"(?:sehr )?(?:dicht|stark|hoh|zähfließend|stockend|lebhaft|rege)\w* verkehr|viel verkehr|stau|(?:berufs|stoß)verkehr"
     r"|verkehr ist (?:sehr )?(?:dicht|stark)|hohe verkehrsdichte", "dense traffic"),
    (r"(?:mäßig|mittler|normal|mitteldicht|durchschnittlich)\w* verkehr|mittlere verkehrsdichte", "moderate traffic"),
    (r"(?:sehr )?(?:wenig|kaum|schwach|dünn|spärlich|leicht|gering|ruhig)\w* verkehr|geringe verkehrsdichte", "sparse traffic"),
    (r"(?:in den|innerhalb der|während der) (?:ersten|nächsten)|innerhalb von|binnen|in weniger als"
     r"|spätestens nach|nach höchstens"
     r"|innerhalb", "within"),
    (r"(?:um|rund um) (?:das |unser )?(?:ziel|ego)(?:fahrzeug)?(?: herum)?|um uns(?: herum)?|ringsum", "around the target"),
    (r"(?:im |mit )?(?:einem )?abstand von", "at a distance of"), (r"entfernt|entfernung", "away"),
    (r"(?:das ziel|das ego|das test|unser|mein) ?(?:fahrzeug|auto|wagen) ist", "the target is"),
)  # fmt: skip
_WORDS = {
    _EGO: "the ego", r"ein paar|einige": "a few", r"mehrere[nr]?": "several", r"viele[nr]?": "many", r"ein(?:e[nmrs]?)?": "a",
    r"keine?[nmrs]?|kein": "no", r"ohne": "without", r"nicht": "not",
    r"stehende[rsnm]?|liegengebliebene[rsnm]?|parkende[rsnm]?": "stopped",
    r"defekte[rsnm]?|geparkte[rsnm]?": "stopped",
    r"steht(?: still)?|stehen|parkt|hält|liegengeblieben|ist stehengeblieben": "is stopped",
    _CAR: "car", _TRUCK: "truck", _BUS: "bus", _ANY: "vehicle", r"motorrad|motorräder": "motorbike", r"straßenbahn": "tram",
    r"(?:rad|fahrrad)\w*": "cyclist", r"fußgänger\w*": "pedestrian", r"vordermann": "leader",
    r"hintermann": "follower", r"vorausfahrende[rsnm]?": "leading", r"nachfolgende[rsnm]?|folgende[rsnm]?": "following",
    r"jemand|einer": "somebody", r"vorne?|voraus": "ahead", r"davor": "ahead of it",
    r"dahinter": "behind it", r"hinten": "behind us",
    r"links": "on the left",
    r"rechts": "on the right", r"und|sowie": "and", r"während|wobei": "while", r"aber": "but", r"das|der|die|dem|den|des": "the",
    r"etwa|ungefähr|rund|ca\.?|zirka|mit": "about", r"sekunden?": "seconds", r"metern?": "m", r"nach": "after", r"uns|mir": "us",
    r"wir": "we", r"ihm|ihn": "it", r"fährt|fahren|fahrend": "drives", r"kommt|kommen": "comes", r"alle": "everybody",
    r"ist|sind": "is",
    r"wird": "is", r"von": "by", r"vor": "ahead of", r"hinter": "behind", r"neben": "beside",
    r"dutzend": "12", r"stundenkilometern?": "km/h", r"unser\w*": "our", r"dicht": "dense",
}  # fmt: skip


def in_english(clause: str) -> str:
    """A clause in lower case English words; what is not known stays as it is."""
    clause = clause.lower()
    for pattern, english in _PHRASES:
        clause = re.sub(rf"\b(?:{pattern})(?!\w)", english, clause)
    clause = re.sub(rf"\b({'|'.join(_NUMBERS)})\b", lambda m: str(_NUMBERS[m[1]]), clause)
    known = "|".join(f"({pattern})" for pattern in _WORDS)
    words = list(_WORDS.values())
    return re.sub(rf"\b(?:{known})(?!\w)", lambda m: words[(m.lastindex or 1) - 1], clause)
