"""What no road can be, whatever else is said of it."""

import re
from collections.abc import Callable

from drivegen.errors import UnusableInput

_BENDS = r"(?:bends?|bent|curv(?:e|es|ed|ing|y)|turns?|hairpins?|corners?)\b(?! ?(?:lanes?|pockets?|bays?|signs?))"
_FEW = r"(?:(?!(?:no|not|without|zero|then|later|before|after|never)\b)\w+ ){0,3}?"
_PERFECTLY = r"(?:perfectly|completely|totally|absolutely|entirely|dead|arrow|strictly|exactly|100 %) straight"
_NO_BENDS = rf"(?:without|no|not) (?:a single |any )?{_BENDS}(?: at all)?"
_ROAD = r"(?:road|street|highway|motorway|freeway|expressway|carriageway|avenue|lane)s?"
_PLACE = r"(?:crossings?|cross ?roads?|intersections?|junctions?|(?:t |y )?junctions?)"
_HAS = r"(?:with|that has|having)"
_LIGHTS = r"(?:traffic )?(?:lights|signals)"
_DEAD_END = r"(?:cul de sac|dead end(?: \w+)?|no through road|blind alley)s?"
_BOTH_WAYS = r"(?:both|either) (?:directions?|ways?)"
_TWO_WAY = r"(?:2|two) way"
_SAME_ROAD = rf"(?:(?!(?:{_ROAD}|cross\w*|meet\w*|join\w*|lanes|and|an?|another|pairs?|opposite)\b)[\w,]+ ){{0,10}}?"
_THAT = r"(?:(?:that|which|but|and|yet|,) )*"
_END = r"(?: ?[,.]| at all| whatsoever|$)"
_IMPOSSIBLE = {
    r"minus \d+|(?<![\d.] )(?<![\d.])0 (?:m|km|ft|yd|mile)\b": "numbers must be positive",
    r"same (?:bearing|heading|angle|compass direction)": "roads that meet must lie apart",
    r"(?:arms|legs|roads|approaches|branches) (?:\w+ ){0,5}same direction": "roads that meet must lie apart",
    rf"parallel {_ROAD} {_THAT}(?:cross|intersect|meet)(?= each| 1 another| one another| at| in|{_END})": "parallels never meet",
    rf"(?:{_PERFECTLY}|straight) (?:hairpin|curve|bend)s?\b": "what is straight has no bends",
    rf"{_PERFECTLY} {_FEW}(?:that|which|with|and it|but it|yet) {_FEW}{_BENDS}": "what is straight has no bends",
    rf"straight (?:\w+ )?(?:road|street|highway|motorway) (?:that|which) {_FEW}{_BENDS}": "what is straight has no bends",
    rf"straight {_ROAD} (?:with|of|and) (?:an? )?(?:(?:curve|bend) )?radius": "what is straight has no bends",
    rf"straight {_ROAD} (?:that|which) (?:is|forms|makes) an? (?:full )?(?:circle|ring|loop)": "what is straight has no bends",
    rf"(?<!no )(?<!out )(?<!any )(?<!gle )(?:hairpin|s curve|s|curve|bend)s?(?: road)? {_THAT}(?:is |runs )?"
    rf"{_PERFECTLY}(?! (?:{_ROAD}|section|part|approach|stretch|piece|before|after|otherwise|on))": "straight has no bends",
    rf"{_BENDS} (?:\w+ ){{0,8}}?never (?:bends|turns|curves)\b": "bends are asked for and denied",
    rf"{_NO_BENDS} {_THAT}{_FEW}{_BENDS}(?<!hairpins)": "bends are asked for and denied",
    rf"{_NO_BENDS} {_THAT}{_FEW}turn(?:s|ing) (?:by |through )?\d+ degrees": "bends are asked for and denied",
    r"(?:curve|bend|hairpin)s?(?: road)? (?:without|with no) (?:a single |any )?(?:bends?|curves?|turns?)\b(?! lanes?)": (
        "bends are asked for and denied"
    ),
    rf"one way {_ROAD}(?: only)? {_SAME_ROAD}{_BOTH_WAYS}": "a one-way road has one direction",
    rf"one way {_ROAD} (?:with|that has|that is|which is|carrying|for) {_TWO_WAY}\b|{_TWO_WAY} one way|one way {_TWO_WAY}": (
        "a one-way road has one direction"
    ),
    rf"one way {_ROAD} (?:with|that has|carrying) oncoming": "a one-way road has one direction",
    rf"{_DEAD_END} {_THAT}(?:is |are |being )?(?:open|connected|joined|linked)(?: to \w+)? at (?:both|either) ends?": (
        "a dead end has one way out"
    ),
    rf"{_DEAD_END} (?:that|which) (?:leads?|runs?|goes|continues) (?:straight |right |on )*through": "a dead end has one way out",
    rf"(?:without|no|0|zero) (?:any )?(?:driving |traffic )?lanes(?: in (?:either|any|each|both) directions?)?(?={_END})": (
        "a road needs at least one lane"
    ),
    r"half (?:of )?a lane|\d\.\d+ lanes?": "lanes are counted in whole numbers",
    rf"weav\w+(?: \w+)? (?:without|with no|but no) (?:any |a single |an? |on |off |entry |exit )*ramps?(?={_END})": (
        "where traffic weaves, ramps join and leave"
    ),
    rf"(?:uncontrolled|unregulated|(?:all|4|3) way stop)(?: controlled)?(?: \w+)? {_PLACE} {_HAS} (?:\w+ )?{_LIGHTS}": (
        "one rule decides who goes first"
    ),
    r"grid (?:with|of|made of|from) (?:only |just )?(?:1|a single|one) (?:street|road)\b": "a grid needs streets that cross",
    r"roundabout (?:without|with no) (?:an? |any )?(?:ring|circulat\w+|circle)\b": "a roundabout is a ring",
    r"stagger\w+(?: \w+)? with (?:only |just )?(?:a single|1|one) side (?:road|street)": "two side roads are staggered",
    r"fork\w* (?:into|with) (?:only |just )?(?:1|a single) (?:branch|road|arm|way)\b": "a fork has two branches",
    r"fork\w*(?: \w+){0,4} (?:does not|doesn t|never) (?:split|fork|divide)s?": "a fork has two branches",
    r"(?:on|entry|entrance) ?ramp (?:through|by|via|over|on|at) which (?:\w+ ){0,3}?(?:leave|exit)s?\b": "on-ramps join",
    r"(?:on|entry|entrance) ?ramp (?:that|which) (?:leaves|exits|diverges)": "on-ramps join",
    r"(?:off|exit) ?ramp (?:through|by|via|over|on|at) which (?:\w+ ){0,3}?(?:join|enter|merge)s?\b": "off-ramps leave",
    r"(?:all|every)\b[^.]{0,40}\bone way (?:streets? |roads? )?(?:towards?|into|inwards|away from|out of)": (
        "there must be a way in and a way out"
    ),
}
_N = r"(\d+(?:\.\d+)?)"
_METRES = {"m": 1.0, "km": 1000.0, "ft": 0.3048, "yd": 0.9144, "mile": 1609.344}
_LENGTH = rf"{_N} (m|km|ft|yd|mile)"
_TOO = r"(?:(?:and|but|yet) )?(?:(?:is|it|has|are) )?(?:also|at the same time|simultaneously|likewise)"
_OF_IT = r"(?: (?:is|has|a|an|of|limit|speed|long|length|exactly|the|at|same|time|being|total))*"
_ONE_ROAD = (
    rf"(?: (?:straight|curved|one way))?(?: {_ROAD})?(?: (?:that|which|and|but|with|has|is|a|also|it|exactly|only|,)){{1,6}}"
)
_WHOLE = r"(?: (?:total|overall))? length of"


def _different(a: str, b: str) -> bool:
    return float(a) != float(b)


def _different_lengths(a: str, unit_a: str, b: str, unit_b: str) -> bool:
    first, second = float(a) * _METRES[unit_a], float(b) * _METRES[unit_b]
    return abs(first - second) > 0.05 * max(first, second)


_COMPARED: tuple[tuple[str, Callable[..., bool], str], ...] = (
    (
        rf"(?:narrow\w*|lane (?:drop|reduction|loss)|reduc\w+|taper\w*)(?: down)? from {_N}(?: lanes?)? to {_N}",
        lambda a, b: float(a) <= float(b),
        "a road that narrows has fewer lanes afterwards",
    ),
    (
        rf"(?:widen\w*|lane (?:gain|addition)|broaden\w*|expand\w*)(?: out| up)? from {_N}(?: lanes?)? to {_N}",
        lambda a, b: float(a) >= float(b),
        "a road that widens has more lanes afterwards",
    ),
    (
        rf"{_N} lane {_ROAD} (?:with|that has|having) (?:only|just|exactly) {_N} lanes(?! per| in| each)",
        _different,
        "lanes differ",
    ),
    (rf"{_N} (?:kmh|mph)(?: (?:speed )?limit)? {_TOO}{_OF_IT} {_N} (?:kmh|mph)", _different, "a road has one speed limit"),
    (rf"{_LENGTH}(?: apart| long)? {_TOO}{_OF_IT} {_LENGTH}", _different_lengths, "lengths differ"),
    (rf"{_LENGTH} long{_ONE_ROAD} {_LENGTH} long", _different_lengths, "lengths differ"),
    (rf"{_LENGTH} long{_ONE_ROAD}{_WHOLE} {_LENGTH}", _different_lengths, "lengths differ"),
    (rf"length of {_LENGTH}{_ONE_ROAD} {_LENGTH} long", _different_lengths, "lengths differ"),
    (
        r"hairpin(?: bend| curve| turn)? (?:of|with|turning|by|through) (?:an angle of )?(\d+) degrees",
        lambda angle: float(angle) < 90.0,
        "a hairpin turns back",
    ),
    (
        rf"{_N} (?:[a-z]+ ){{1,5}}?(?:, )?of (?:which|them|these) (?:only )?{_N}(?! (?:m|km|kmh|mph|lanes?|arms?)\b)",
        lambda all_of_them, some: float(some) > float(all_of_them),
        "some are no more than all",
    ),
    (
        rf"{_N} lanes? (?:per|in each|each) (?:direction|way) (?:that|which|but|and) (?:has|have|is|with) "
        rf"(?:\w+ )?{_N} lanes? (?:per|in each|each)",
        _different,
        "lanes differ",
    ),
    (
        rf"{_N} lanes? per direction {_ROAD} (?:with|that has|having) (?:\w+ )?{_N} lanes? (?:per|in each|each)",
        _different,
        "lanes differ",
    ),
)


def refuse_impossible(plain: str) -> None:
    """Raise UnusableInput where a normalised description contradicts itself or geometry."""
    for pattern, reason in _IMPOSSIBLE.items():
        if found := re.search(rf"\b(?:{pattern})", plain):
            raise UnusableInput(f"{found.group()!r} makes no road: {reason}", reason="impossible-map")
    for pattern, wrong, reason in _COMPARED:
        for found in re.finditer(rf"(?<![\d.])\b(?:{pattern})", plain):
            if wrong(*found.groups()):
                raise UnusableInput(f"{found.group()!r} makes no road: {reason}", reason="impossible-map")
