"""German descriptions, word by word in English."""

import re

from drivegen.maps.writers._lexicon import longest

_OF_WHICH = r"\w*spur|\w*streifen|seite|ende|arm|rand|teil"
_THERE = "(?:hier |dort |da |dabei )?"
GERMAN_NUMBERS = {
    "zwei": 2, "drei": 3, "vier": 4, "fünf": 5, "sechs": 6, "sieben": 7, "acht": 8, "neun": 9, "zehn": 10, "zwölf": 12,
}  # fmt: skip
_GERMAN_COUNTED = {"spur": "lane", "streif": "lane", "arm": "arm", "strahl": "arm"}
_GERMAN_COMPOUND = re.compile(
    r"\b(\w{3,}?)s?(kreuzung(?:en)?|kreisel|kreisverkehre?|straßen?|kurven?|einmündung(?:en)?|gassen?|spur(?:en)?)\b"
)
GERMAN_WORDS = {
    "versetzte kreuzung": "staggered junction", "t kreuzung": "t junction", "t einmündung": "t junction",
    "einmündung": "t junction", "kreuzungen": "intersections", "straßenkreuzung": "intersection", "kreuzung": "intersection",
    "kreisverkehre": "roundabouts", "kreisverkehr": "roundabout", "kreisel": "roundabout", "schnellstraße": "expressway",
    "vereinigen": "merge", "vereinigt": "merges", "vereinen": "merge", "zu einer": "into one", "zu": "to", "je": " ",
    "zusätzlicher": "extra", "zusätzliche": "extra", "zusätzlichen": "extra", "hauptfahrstreifen": "mainline lanes",
    "dazwischen": "between them", "autobahnabschnitt": "motorway", "autobahnstrecke": "motorway",
    "autobahnteilstück": "motorway",
    "geradeaus": "straight",
    "autobahnstück": "motorway", "zweier autobahnen": "of 2 motorways", "kleeblatt": "cloverleaf",
    "autobahnkleeblatt": "cloverleaf",
    "kleeblattkreuz": "cloverleaf", "halbes kleeblatt": "partial cloverleaf", "halbkleeblatt": "partial cloverleaf",
    "trompete": "trumpet", "trompetenknoten": "trumpet", "schleifenrampe": "loop ramp", "schleifenrampen": "loop ramps",
    "autobahnkreuz als": " ", "autobahndreieck als": " ",
    "autobahnauffahrt": "highway on ramp", "autobahnausfahrt": "highway off ramp", "auffahrt": "on ramp",
    "einfahrt": "on ramp",
    "ausfahrt": "off ramp", "abfahrt": "off ramp", "lichtsignalanlage": "traffic lights", "ampelanlage": "traffic lights",
    "ampeln": "traffic lights", "ampel": "traffic lights", "ampelgeregelte": "signalised", "signalisierte": "signalised",
    "ohne": "without", "keinen": "no", "keine": "no", "kein": "no", "mit": "with", "und": "and", "oder": "or",
    "fahrspuren": "lanes", "fahrstreifen": "lanes", "spuren": "lanes", "fahrspur": "lane", "spur": "lane",
    "pro richtung": "per direction", "je richtung": "per direction", "in jede richtung": "in each direction",
    "in jeder richtung": "in each direction", "je fahrtrichtung": "per direction", "pro fahrtrichtung": "per direction",
    "tempolimit": "speed limit", "höchstgeschwindigkeit": "speed limit", "geschwindigkeitsbegrenzung": "speed limit",
    "tempo": "speed limit", "gerade": "straight", "kurvige": "curved", "kurve": "curve", "s kurve": "s curve",
    "haarnadelkurve": "hairpin", "spitzkehre": "hairpin", "straßenraster": "street grid", "straßengitter": "street grid",
    "raster": "grid", "gitter": "grid", "landstraße": "rural road", "wohnstraße": "residential street",
    "hauptstraße": "main road", "nebenstraßen": "side roads", "nebenstraße": "side road", "seitenstraßen": "side streets",
    "seitenstraße": "side street", "einbahnstraßen": "one way streets", "einbahnstraße": "one way street",
    "sackgasse": "cul de sac", "straßen": "roads", "straße": "road", "strasse": "road", "armen": "arms", "arme": "arms",
    "ästen": "arms", "ausfahrten": "exits", "gabelung": "fork", "treffen sich": "meet", "treffen": "meet",
    "verengt sich": "narrows", "verengt": "narrows", "sich": " ", "einer spur": "1 lane", "eine spur": "1 lane",
    "einer fahrspur": "1 lane", "eine fahrspur": "1 lane", "stoppschilder": "stop signs", "stoppschild": "stop signs",
    "vorfahrt gewähren": "yield", "rechts vor links": "right before left", "lange": "long", "lang": "long", "meter": "m",
    "kilometer": "km", "durchmesser": "diameter", "im abstand von": "spaced", "linksverkehr": "left hand traffic",
    "grad": "degrees", "linksabbiegespuren": "left turn lanes", "linksabbiegespur": "left turn lanes",
    "abbiegespuren": "turn lanes", "nach links": "to the left", "nach rechts": "to the right", "hintereinander": "in a row",
    "abstand": "apart", "scharfe": "sharp", "scharfer": "sharp", "von": "from", "auf": "to", "einer": "a", "einem": "a",
    "einen": "a", "eines": "a", "eine": "a", "ein": "a", "der": "the", "die": "the", "das": "the", "nach": "after",
    "erst": "first", "dann": "then", "danach": "then", "vor": "before", "bei": "at", "zwischen": "between",
    "gibt es": "there is", "verbreitert sich": "widens", "aus": "of", "wird": "becomes", "werden": "become",
    "versetzte einmündungen": "staggered junction", "versetzt": "staggered", "versetzte": "staggered", "weitere": "another",
    "kommt": "comes", "hinzu": "in addition", "auf einer": "on a", "auf einem": "on a", "auf der": "on the",
    "linkskurve": "curve to the left", "rechtskurve": "curve to the right", "doppelkurve": "s curve", "kurven": "curves",
    "nur": "only", "erste": "first", "erster": "first", "ersten": "first", "zweite": "second", "zweiter": "second",
    "zweiten": "second", "dritte": "third", "dritten": "third", "letzte": "last", "letzten": "last", "hat": "has",
    "haben": "have",
    "sind": "are", "ist": "is", "aber": "but", "sowie": "and", "später": "later", "weiter": "further", "anschließend": "then",
    "beträgt": "is", "bögen": "curves", "bogen": "curve", "vom anfang": "from the start", "am anfang": "at first",
    "hinter": "after",
    "von denen": "of which", "wovon": "of which", "außendurchmesser": "outer diameter", "benachbarten": "adjacent",
    "benachbarte": "adjacent", "länge": "length",
    "langem": "long", "langer": "long",
    "langen": "long", "kreis": "ring", "außerhalb": "outside",
    "haarnadelkurven": "hairpins", "spitzkehren": "hairpins", "kehren": "hairpins", "kehre": "hairpin",
    "serpentinen": "hairpins", "linksbogen": "curve to the left", "rechtsbogen": "curve to the right", "radius": "radius",
    "zufahrten": "arms", "zufahrt": "arm", "zufahrtsstraßen": "arms", "knotenarme": "arms", "knotenarm": "arm",
    "kreisverkehrsplatz": "roundabout", "minikreisel": "mini roundabout", "kreisfahrbahn": "circulating carriageway",
    "knotenpunkt": "intersection", "knotenpunkte": "intersections", "einmündungen": "t junctions", "abzweigung": "t junction",
    "querstraßen": "cross streets", "querstraße": "cross street", "stichstraße": "cul de sac", "sackgassen": "cul de sacs",
    "wendehammer": "turning head", "wendeplatz": "turning place", "wohngebiet": "residential area", "allee": "avenue",
    "bundesstraße": "rural road", "kreisstraße": "rural road", "dorfstraße": "village street", "gasse": "alley",
    "autobahnen": "motorways", "bundesautobahn": "motorway", "fahrbahn": "carriageway",
    "richtungsfahrbahn": "one way carriageway",
    "mittelstreifen": "median", "grünstreifen": "median", "standstreifen": "shoulder", "getrennte": "separate",
    "beschleunigungsstreifen": "acceleration lane", "einfädelungsstreifen": "acceleration lane",
    "einfädelstreifen": "acceleration lane", "einfädelspur": "acceleration lane", "beschleunigungsspur": "acceleration lane",
    "verzögerungsstreifen": "deceleration lane", "ausfädelungsstreifen": "deceleration lane",
    "ausfädelstreifen": "deceleration lane", "verflechtungsstrecke": "weaving section",
    "verflechtungsbereich": "weaving section", "auffahrten": "on ramps", "abfahrten": "off ramps", "rampe": "ramp",
    "rampen": "ramps", "autobahnauffahrten": "on ramps", "autobahnausfahrten": "off ramps", "halteschild": "stop sign",
    "lichtsignalanlagen": "traffic lights", "verkehrsampel": "traffic lights", "verkehrsampeln": "traffic lights",
    "unsignalisierte": "unsignalised", "lichtsignalgeregelte": "signalised", "ampelgesteuerte": "signalised",
    "signalgeregelte": "signalised", "beampelte": "signalised", "vorfahrtsstraße": "main road", "vorfahrtstraße": "main road",
    "versetzte kreuzungen": "staggered junction", "y kreuzung": "y junction", "x kreuzung": "crossing",
    "haltelinie": "stop line", "vorfahrt": "yield signs", "schnurgerade": "straight", "kerzengerade": "straight",
    "gerader": "straight", "gerades": "straight", "geraden": "straight", "sanfte": "gentle", "sanfter": "gentle",
    "enge": "tight", "enger": "tight", "weite": "gentle", "innerstädtische": "urban", "innerorts": "urban",
    "außerorts": "rural", "in fahrtrichtung": "in the direction of travel", "in jeder fahrtrichtung": "in each direction",
    "beiden richtungen": "each direction", "beide richtungen": "each direction", "richtung": "direction",
    "insgesamt": "in total", "überall": "everywhere", "jede": "each", "jeder": "each", "jedem": "each", "jeden": "each",
    "alle": "all", "allen": "all", "beide": "both", "beiden": "both", "kreuzt": "crosses", "kreuzen sich": "cross",
    "kreuzen": "cross", "quert": "crosses", "mündet": "joins", "münden": "join", "in eine": "to a", "in einen": "to a",
    "gabelt sich": "forks", "teilt sich": "splits", "sich gabelt": "forks", "sich teilt": "splits", "aufteilt": "splits",
    "vereinigen sich": "merge", "werden zu": "become", "wird zu": "becomes", "reduziert sich": "narrows",
    "erweitert sich": "widens", "weitet sich": "widens", "endet": "ends", "fällt weg": "ends", "rechte": "right",
    "rechter": "right", "linke": "left", "linker": "left", "rechts": "right", "links": "left", "in folge": "in a row",
    "nacheinander": "in a row", "aufeinander folgende": "consecutive", "aufeinanderfolgende": "consecutive",
    "entfernt": "apart", "voneinander": "", "entfernung": "distance", "meilen": "miles", "stundenkilometer": "kmh",
    "mal": "by",
    "rasternetz": "grid", "straßennetz": "street grid", "schachbrettmuster": "grid", "im": "in the", "ring": "ring",
    "breite": "wide", "breiter": "wide", "breiten": "wide", "jeweils": "each", "für": "for", "an": "at",
    "keine davon": "none of them", "keiner davon": "none of them", "keines davon": "none of them", "davon": "of them",
    "rechten": "right", "linken": "left", "seite": "side", "seiten": "sides", "auseinander": "apart", "feldweg": "farm track",
    "verschiedenen": "opposite", "gegenüberliegenden": "opposite", "entlang": "along", "einbahnregelung": "one way traffic",
    "zeilen": "rows", "reihen": "rows", "spalten": "columns", "gitternetz": "grid", "blocklänge": "block length",
    "linksabbiegestreifen": "left turn lanes", "rechtsabbiegespur": "right turn lanes", "versatz": "offset",
    "rechtsabbiegespuren": "right turn lanes", "rechtsabbiegestreifen": "right turn lanes", "abbiegestreifen": "turn lanes",
    "unbeampelte": "unsignalised", "ampellose": "unsignalised", "ampelfreie": "unsignalised", "seitliche": "side",
    "häuserblocks": "blocks", "häuserblöcke": "blocks", "minikreisverkehr": "mini roundabout",
    "einbahnig": "one way", "laufen": "run", "am rand": "at the edge", "noch": "another", "abzweigungen": "junctions",
    "wieder": "another", "nochmals": "another",
    "fehlen": "are missing", "fehlt": "is missing", "gerade strecken": "straight sections", "schmaler": "narrow",
    "schmale": "narrow", "rechtskurven": "curves to the right", "linkskurven": "curves to the left",
    "des": "the", "dem": "the", "den": "the", "durch": "through", "ländliche": "rural", "städtische": "urban",
}  # fmt: skip


def from_german(text: str) -> str:
    """A lowercase German text with the words that are known replaced."""
    text = re.sub(r"(?<=\w)-(?=\w)", " ", re.sub(r"(?<=\d),(?=\d)", ".", text))
    text = re.sub(r"(?<=straße) (?:einen|eine|einer)(?= ?(?:[,.;)]|$|und\b))", " 1", text)  # "die Nebenstraße einen"
    text = re.sub(rf"\b(\w+(?: (?:oder|und) \w+)*) (?:gibt es {_THERE}(?:nicht|keine|keinen)|fehlen|fehlt)\b", r"keine \1", text)
    text = re.sub(r"\b(\w+) (?:auch|ebenfalls|ebenso) nicht\b", r"keine \1", text)
    text = re.sub(r"\bfährt auf ([^,.]*?) auf\b", r"mündet auf \1", text)
    text = re.sub(rf"\b({_OF_WHICH}) (?:einer|eines) ", r"\1 of a ", text)
    text = re.sub(r"\b(\w+spurig) (wird|werden)\b", r"\2 \1", text)
    numbers = {"ein": 1, **GERMAN_NUMBERS}
    text = re.sub(rf"\b({'|'.join(numbers)})({'|'.join(_GERMAN_COUNTED)})ig(?:e[rsnm]?)?\b", _german_counted, text)
    text = _GERMAN_COMPOUND.sub(lambda m: m[0] if m[0] in GERMAN_WORDS else f"{m[1]} {m[2]}", text)
    words = {**GERMAN_WORDS, **{word: str(number) for word, number in GERMAN_NUMBERS.items()}}
    # Adjectives may carry any ending; they are listed with -e.
    pattern = "|".join(re.escape(w[:-1]) + "(?:e|er|es|en|em)" if w.endswith("ige") else re.escape(w) for w in longest(words))
    endings = re.compile(r"(?<=ig)(?:er|es|en|em)$")
    return re.sub(rf"\b(?:{pattern})\b", lambda m: words.get(m[0]) or words[endings.sub("e", m[0])], text)


def _german_counted(match: re.Match[str]) -> str:
    """Adjectives of a number: "einspurig", "fünfarmige"."""
    return f"{({'ein': 1} | GERMAN_NUMBERS)[match[1]]} {_GERMAN_COUNTED[match[2]]}"
