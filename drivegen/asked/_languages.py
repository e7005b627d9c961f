"""German and Chinese words of traffic, phrase by phrase in English; and which clauses of such a text are about traffic."""

import re

_GERMAN_NUMBERS = {
    "ein": 1, "eine": 1, "einen": 1, "einem": 1, "einer": 1, "zwei": 2, "drei": 3, "vier": 4, "fünf": 5, "sechs": 6, "sieben": 7,
    "acht": 8, "neun": 9, "zehn": 10, "elf": 11, "zwölf": 12, "fünfzehn": 15, "zwanzig": 20,
}  # fmt: skip
_GERMAN = {
    r"auto": "car", r"(?:personenwagen|autos|pkws?|wagen)": "cars", r"(?:lastwagen|lkws?|laster)": "trucks",
    r"bus(?:se|sen)?": "buses",
    r"fahrzeuge?n?": "vehicles", r"(?:um|rund um) das (?:ziel|ego)fahrzeug(?: herum)?": "around the target",
    r"das (?:ziel|ego)fahrzeug": "the target",
    r"dichte[rmsn]? verkehr|dicht": "dense traffic", r"wenig verkehr|dünner verkehr": "sparse traffic",
    r"(?:etwa|ungefähr|rund|ca\.?|mit)": "about", r"schert (?:von )?(?:rechts|links) ein|schert ein": "cuts in",
    r"von rechts": "from the right", r"von links": "from the left",
    r"innerhalb von|binnen": "within", r"nach": "after", r"sekunden?": "seconds",
    r"bremst (?:stark|scharf|plötzlich|voll)": "brakes hard",
    r"vorausfahrende[rs]?": "leading", r"entgegenkommende[rs]?": "oncoming", r"biegt links ab": "turns left",
    r"biegt rechts ab": "turns right", r"überholt": "overtakes", r"steht": "stopped", r"stehende[rsn]?": "stopped",
    r"wechselt nach links": "changes to the left lane", r"wechselt nach rechts": "changes to the right lane",
    r"vorne|voraus|davor": "ahead", r"dahinter|hinten": "behind", r"und": "and", r"das|der|die|dem|den": "the",
    r"links daneben": "in the left lane", r"rechts daneben": "in the right lane", r"meter": "m",
}  # fmt: skip
_GERMAN_SIGN = re.compile(
    r"\b(?:fahrzeuge?n?|autos|pkw|lkw|lastwagen|busse|bremst|überholt|schert|verkehr|sekunden?|entgegenkommende\w*)\b"
)
_GERMAN_SIDES = (
    (r"schert (?:von )?rechts ein", "cuts in from the right"),
    (r"schert (?:von )?links ein", "cuts in from the left"),
    (r"biegt vor (?:uns|mir|dem (?:ziel|ego)fahrzeug) links ab", "turns left across our path"),
)
_GERMAN_PLACES = (
    (r"vor (?:uns|mir|dem (?:ziel|ego)fahrzeug)", "ahead of the target"),
    (r"hinter (?:uns|mir|dem (?:ziel|ego)fahrzeug)", "behind the target"),
)

_CHINESE_SIGN = re.compile(r"[一-鿿]")
_DIGITS = dict(zip("一二两三四五六七八九", (1, 2, 2, 3, 4, 5, 6, 7, 8, 9), strict=True))
_CHINESE = {
    "目标车辆": " the target ", "目标车": " the target ", "本车": " the target ", "周围": " around ",
    "小汽车": " cars ", "轿车": " cars ",
    "汽车": " cars ", "卡车": " trucks ", "货车": " trucks ", "公交车": " buses ", "巴士": " buses ", "大客车": " buses ",
    "车辆": " vehicles ", "前车": " the leading car ", "前方车辆": " the leading vehicle ", "车流": " traffic ",
    "车流密集": " dense traffic ", "车流稀疏": " sparse traffic ", "对向": " oncoming ",
    "左转": " turns left ", "右转": " turns right ",
    "从右侧": " from the right ", "从左侧": " from the left ", "从右边": " from the right ", "从左边": " from the left ",
    "切入": " cuts in ", "加塞": " cuts in ", "急刹车": " brakes hard ", "急刹": " brakes hard ", "超车": " overtakes ",
    "停在前方": " stopped ahead ", "停着": " stopped ", "向左变道": " changes to the left lane ",
    "向右变道": " changes to the right lane ",
    "前方": " ahead ", "后方": " behind ", "秒": " seconds ", "交通密集": " dense traffic ",
    "密集": " dense ", "交通稀疏": " sparse traffic ", "稀疏": " sparse ", "大约": " about ", "约": " about ",
    "公里每小时": " km/h ", "千米每小时": " km/h ", "公里/小时": " km/h ",
    "米": " m ", "在": " within ", "和": " and ", "处": " ",
    "车": " vehicles ",
}  # fmt: skip
_CHINESE_VEHICLE = re.compile(r"车(?!道)|巴士|密集|稀疏|公里每小时|秒")
_ROAD = re.compile(r"限速|车道|路口|环岛|匝道|高速|kreuzung|kreisverkehr|kreisel|stra(?:ß|ss)e|ampel|tempo|spur", re.IGNORECASE)
_CLAUSES = re.compile(r"(?<!\d)[,.](?!\d)|[;\n，。；、]")


def vehicle_clauses(text: str) -> tuple[str, str]:
    """The clauses that may be about traffic, in English, and the others as they are; an English text is one clause."""
    lower = text.lower()
    if not (_CHINESE_SIGN.search(text) or _GERMAN_SIGN.search(lower)):
        return text, ""
    about: list[str] = []
    others: list[str] = []
    for clause in filter(None, (part.strip() for part in _CLAUSES.split(text))):
        mine = (
            _GERMAN_SIGN.search(clause.lower())
            or _CHINESE_VEHICLE.search(clause)
            or re.search(r"\d ?km/h", clause)
            or _lone(clause)
        )
        (about if mine and not _ROAD.search(clause) else others).append(clause)
    if not about:
        return "", text
    return " , ".join(_in_english(clause) for clause in about), ", ".join(others)


def _lone(clause: str) -> bool:
    """A clause of traffic that names no vehicle: "dicht", "zwei Busse und ein Lkw"."""
    return bool(re.fullmatch(r"(?:sehr )?dicht|(?:\w+ )?(?:bus|auto|lkw|pkw)(?:\W.*)?", clause.lower()))


def _in_english(clause: str) -> str:
    if _CHINESE_SIGN.search(clause):
        clause = re.sub(f"([{''.join(_DIGITS)}])?十([{''.join(_DIGITS)}])?", _tens, clause)
        clause = re.sub(f"([{''.join(_DIGITS)}])(?=[辆台个秒米])", lambda m: str(_DIGITS[m[1]]), clause)
        clause = re.sub(r"(\d+)秒(?:之?内|钟内)", r" within \1 seconds ", re.sub(r"(\d+)[辆台个]", r" \1 ", clause))
        clause = re.sub(r"前方(?:有)?停着(?:的)?(.+)", r"\1停在前方", clause)
        for word in sorted(_CHINESE, key=len, reverse=True):
            clause = clause.replace(word, _CHINESE[word])
        return clause
    clause = clause.lower()
    for pattern, english in (*_GERMAN_SIDES, *_GERMAN_PLACES):
        clause = re.sub(pattern, english, clause)
    clause = re.sub(rf"\b({'|'.join(_GERMAN_NUMBERS)})\b", lambda m: str(_GERMAN_NUMBERS[m[1]]), clause)
    for pattern, english in _GERMAN.items():
        clause = re.sub(rf"\b(?:{pattern})(?!\w)", english, clause)
    return clause


def _tens(match: re.Match[str]) -> str:
    return str(10 * _DIGITS.get(match[1] or "一", 1) + _DIGITS.get(match[2] or "", 0))
