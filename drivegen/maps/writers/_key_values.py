"""Lists of keys and values, as operational design domains are written: "arms = 4; signals: yes" in the words of prose."""

import re

_COUNTED = (
    r"(?:arms|legs|branches|approaches|exits|entries|entrances|carriageways|lanes|junctions|intersections|crossings|roundabouts|"
    r"ramps|rows|columns|hairpins|bends|curves|streets|roads|signals|lights)"
)
_NAME = rf"(?:[a-z][\w-]* ){{0,3}}?(?:[a-z]+-)?{_COUNTED}(?: (?:per|in each|each|in the|on the|on each) \w+)?"
_KINDS = r"(?:road |street |junction |intersection |crossing |network |map |layout |alignment |horizontal )*"
_PLACE = r"(?:junction|intersection|crossing)(?: type| kind| form| layout| geometry| shape)?"
_IS = r" ?(?:=|:) ?"
_END = r"(?= ?(?:[;,.|\n\r)}\]]|$))"
_MEASURES = r"(?:radius|length|spacing|diameter|width|offset|speed(?: limit)?|distance|angle|gap)"
_PATTERNS = (
    (rf"\b(?:driving|traffic|drive)(?: side| hand)?{_IS}(left|right)", r"\1-hand traffic"),
    (rf"\b({_MEASURES}){_IS}(?=\d)", r"\1 "),
    (rf"\b([a-z][\w -]*?){_IS}(?:none|no|nil|absent|not present|false|n/?a|off|0){_END}", r"no \1"),
    (rf"\b(?:number|no\.?|count|total) of ({_NAME}){_IS}(\d+|[a-z]+)(?! ?[a-z\d]){_END}", r"\2 \1"),
    (rf"\b(lane|arm|leg|ramp|exit|junction)s? (?:count|number){_IS}(\d+)", r"\2 \1s"),
    (rf"(?<![\w-])({_NAME}){_IS}(\d+){_END}", r"\2 \1"),
    (rf"\b([a-z][\w -]*?){_IS}(?:yes|present|true|on){_END}", r"\1"),
    (rf"\b{_PLACE}{_IS}(?=(?:an? )?(?:[\w-]+ )?(?:cross ?roads?|crossing|roundabout|[ty][ -]junction)\b)", " "),
    (rf"\b{_PLACE}{_IS}([ty]|\d[ -]?(?:way|leg|arm)\w*){_END}", r"\1 junction"),
    (rf"\b{_KINDS}(?:type|kind|class|form|layout|geometry|shape|category|element|alignment|control){_IS}", r" "),
)


def in_prose(text: str) -> str:
    """The text in lower case, with counted and affirmed keys turned round; other keys and what is no list stay as they are."""
    text = re.sub(r"\s[-|•*]\s(?=[a-z][\w /-]*[:=])", "; ", text.lower())
    for pattern, words in _PATTERNS if re.search(r"[=:]", text) else ():
        text = re.sub(pattern, words, text)
    text = re.sub(r"(?<![=<>])=(?![=>])", " ", text)
    return re.sub(r"\bno one[ -]way\b", "two way", text)
