"""German and Chinese descriptions, word by word in English, for the rules to read.

No grammar: phrases are replaced, longest first, and what has no entry stays as it is and is listed as ignored.
"""

import re

_GERMAN = re.compile(
    r"\b(?:ein|eine|einer|eines|einem|mit|ohne|und|kein|keine|der|die|das|zwei|drei|je|pro|kreuzung|kreisverkehr|straße|ampel)\b"
)
_CHINESE = re.compile(r"[一-鿿]")

_GERMAN_NUMBERS = {
    "zwei": 2, "drei": 3, "vier": 4, "fünf": 5, "sechs": 6, "sieben": 7, "acht": 8, "neun": 9, "zehn": 10, "zwölf": 12,
}  # fmt: skip
_GERMAN_COUNTED = {"spur": "lane", "streif": "lane", "arm": "arm", "strahl": "arm"}
_GERMAN_COMPOUND = re.compile(
    r"\b(\w{3,}?)s?(kreuzung(?:en)?|kreisel|kreisverkehre?|straßen?|kurven?|einmündung(?:en)?|gassen?|spur(?:en)?)\b"
)
_GERMAN_WORDS = {
    "versetzte kreuzung": "staggered junction", "t kreuzung": "t junction", "t einmündung": "t junction",
    "einmündung": "t junction", "kreuzungen": "intersections", "straßenkreuzung": "intersection", "kreuzung": "intersection",
    "kreisverkehre": "roundabouts", "kreisverkehr": "roundabout", "kreisel": "roundabout", "schnellstraße": "expressway",
    "vereinigen": "merge", "vereinigt": "merges", "vereinen": "merge", "zu einer": "into one", "zu": "to", "je": " ",
    "zusätzlicher": "extra", "zusätzliche": "extra", "zusätzlichen": "extra", "hauptfahrstreifen": "mainline lanes",
    "dazwischen": "between them", "autobahnabschnitt": "motorway", "autobahnstrecke": "motorway", "autobahnteilstück": "motorway",
    "geradeaus": "straight",
    "autobahnstück": "motorway",
    "autobahnauffahrt": "highway on ramp", "autobahnausfahrt": "highway off ramp", "auffahrt": "on ramp", "einfahrt": "on ramp",
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
    "haarnadelkurven": "hairpins", "spitzkehren": "hairpins", "kehren": "hairpins", "kehre": "hairpin",
    "serpentinen": "hairpins", "linksbogen": "curve to the left", "rechtsbogen": "curve to the right", "radius": "radius",
    "zufahrten": "arms", "zufahrt": "arm", "zufahrtsstraßen": "arms", "knotenarme": "arms", "knotenarm": "arm",
    "kreisverkehrsplatz": "roundabout", "minikreisel": "mini roundabout", "kreisfahrbahn": "circulating carriageway",
    "knotenpunkt": "intersection", "knotenpunkte": "intersections", "einmündungen": "t junctions", "abzweigung": "t junction",
    "querstraßen": "cross streets", "querstraße": "cross street", "stichstraße": "cul de sac", "sackgassen": "cul de sacs",
    "wendehammer": "turning head", "wendeplatz": "turning place", "wohngebiet": "residential area", "allee": "avenue",
    "bundesstraße": "rural road", "kreisstraße": "rural road", "dorfstraße": "village street", "gasse": "alley",
    "autobahnen": "motorways", "bundesautobahn": "motorway", "richtungsfahrbahn": "carriageway", "fahrbahn": "carriageway",
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
    "entfernt": "apart", "voneinander": "", "entfernung": "distance", "meilen": "miles", "stundenkilometer": "kmh", "mal": "by",
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
    "des": "the", "dem": "the", "den": "the", "durch": "through", "ländliche": "rural", "städtische": "urban",
}  # fmt: skip

_CHINESE_DIGITS = dict(zip("一二两三四五六七八九", (1, 2, 2, 3, 4, 5, 6, 7, 8, 9), strict=True))
_ENDS = {"前": "first", "后": "last"}
_ORDINALS = ("", "first", "second", "third", "fourth", "fifth")
_CHINESE_WORDS = {
    "米后": "m later", "公里后": "km later", "错位交叉口": "staggered junction", "十字路口": "4 way intersection",
    "十字交叉口": "4 way intersection", "丁字路口": "t junction", "T型路口": "t junction", "T形路口": "t junction",
    "T字路口": "t junction", "Y型路口": "y junction", "Y形路口": "y junction", "岔路口": " way intersection",
    "路交叉口": " way intersection", "环形交叉口": "roundabout", "环岛": "roundabout", "转盘": "roundabout",
    "交叉口": "intersection", "路口": "intersection", "高速公路": "highway", "高速路": "highway", "快速路": "expressway",
    "入口匝道": "on ramp", "上匝道": "on ramp", "出口匝道": "off ramp", "下匝道": "off ramp", "匝道": "ramp",
    "红绿灯": "traffic lights", "信号灯": "traffic lights", "交通灯": "traffic lights", "信号控制": "signalised",
    "没有": "without", "减到": "to", "先减到": "to", "先减为": "to", "先增加到": "to", "再": ", then", "由": "from",
    "不要": "without", "不设": "without", "最高时速": "speed limit", "时速": "speed limit", "全长": "long",
    "总长": "long", "单向道路": "one way road", "单向公路": "one way road", "单向行驶": "one way", "单向交通": "one way",
    "单向街道": "one way street", "单向街": "one way street", "单向路": "one way road",
    "不带": "without", "无": "without", "带有": "with", "带": "with", "有": "with",
    "每个方向": "in each direction with", "每方向": "in each direction with", "单向": "in each direction with",
    "条车道": " lanes", "个车道": " lanes", "车道": " lanes", "限速": "speed limit", "公里每小时": "kmh", "千米每小时": "kmh",
    "公里/小时": "kmh", "千米/小时": "kmh", "公里": "km", "千米": "km", "米": "m", "直线道路": "straight road",
    "直路": "straight road", "直道": "straight road", "笔直": "straight", "双车道": "2 lane ", "环道": "ring",
    "环形车道": "ring", "环内": "ring", "每个进口": "on every approach", "每条道路": "on each road", "每条路": "on each road",
    "各方向": "in each direction with", "双向各": "in each direction with", "交织区": "weaving section",
    "交织段": "weaving section", "加速车道": "acceleration lane", "减速车道": "deceleration lane", "驶入匝道": "on ramp",
    "驶出匝道": "off ramp", "汇入匝道": "on ramp", "左弯": "curve to the left", "右弯": "curve to the right",
    "左转弯": "curve to the left", "右转弯": "curve to the right", "急弯": "sharp curve", "回头弯": "hairpin",
    "连续": "consecutive", "次要道路": "side road", "次路": "side road", "停车让行": "stop signs", "减速让行": "yield signs",
    "无信号灯": "without traffic lights", "三岔路口": "3 way intersection", "间隔": "spaced", "间距": "spaced",
    "中央分隔带": "median", "中央隔离带": "median", "分隔带": "median", "左转专用道": "left turn lanes",
    "右转专用道": "right turn lanes", "专用左转车道": "left turn lanes", "单车道": "1 lane ", "半径": "radius",
    "尽头路": "cul de sac", "分成": "splits into", "分为": "splits into", "汇合": "merge", "合并": "merge", "交叉": "cross",
    "直行": "straight", "直线": "straight", "路段": "road", "主线": "mainline", "靠右行驶": "right hand traffic",
    "增加到": "to", "增加为": "to", "变成": "to", "扩宽": "widens", "右侧": "right", "左侧": "left", "先": "first", "后": ",",
    "弯道": "curve", "弯路": "curved road", "弯曲": "curved", "S形弯": "s curve", "S弯": "s curve", "S型弯": "s curve",
    "发夹弯": "hairpin", "网格": "grid", "棋盘": "grid", "单行道": "one way street", "断头路": "cul de sac",
    "死胡同": "cul de sac", "道路": "road", "公路": "road", "街道": "street", "马路": "road", "乡村": "rural", "城市": "urban",
    "住宅区": "residential", "主路": "main road", "主干道": "main road", "支路": "side road", "停车标志": "stop signs",
    "让行": "yield", "变为": "to", "减少到": "to", "减为": "to", "缩减为": "to", "从": "from", "出口": " exits", "臂": " arms",
    "靠左行驶": "left hand traffic", "左行": "left hand traffic", "直径": "diameter", "相距": "spaced", "度": "degrees",
    "向左": "to the left", "向右": "to the right", "分叉": "fork", "左转车道": "left turn lanes",
    "右转车道": "right turn lanes", "和": "and", "，": ",", "。": ".", "、": ",", "的": ",", "一个": "a ", "一条": "a ",
    "双向道路": "2 way road", "双向通行": "2 way traffic",
    "双向行驶": "2 way traffic", "弯": "bend", "与": "and", "住宅小区": "residential", "小区": "residential", "十字交叉": "cross",
    "左侧通行": "left hand traffic", "右侧通行": "right hand traffic", "依次": "in a row", "四个方向": "on all arms",
    "最后一个": "the last",
    "长": "long", "每个": "each", "连成一排": "in a row", "一排": "in a row", "棋盘式路网": "grid", "路网": "grid",
    "左转专用车道": "left turn lanes", "右转专用车道": "right turn lanes", "各进口": "on every approach",
    "各进口道": "on every approach", "每个进口道": "on every approach", "均": "all", "都": "all", "设有": "with",
    "设置": "with", "设": "with", "相交": "cross", "无灯控": "unsignalised", "让行标志": "yield signs",
    "停车标志控制": "stop signs", "全向停车": "all way stop", "环形路口": "roundabout",
}  # fmt: skip


_ENGLISH_TOO = frozenset(
    ("die", "des", "den", "tempo", "lang", "von", "auf", "raster", "radius", "ring", "alle", "an", "links", "im")
)
_ONLY_GERMAN = (frozenset(_GERMAN_WORDS) | frozenset(_GERMAN_NUMBERS)) - _ENGLISH_TOO


def in_english(text: str) -> str:
    """`text` with German or Chinese words replaced; an English text comes back as it is."""
    if _CHINESE.search(text):
        return _from_chinese(text)
    lower = text.lower()
    if (
        len(_GERMAN.findall(lower)) >= 2
        or len(set(re.findall(r"\w+", lower)) & _ONLY_GERMAN) >= 2
        or re.search(
            r"[äöüß]|(?:kreuzung|kreisverkehr|kreisel|sackgasse|straße|autobahn\w+|\w+kurven?|fahrstreifen|fahrspur(?:en)?|\w+spurige?r?|einbahn\w+)\b",
            lower,
        )
    ):
        return _from_german(lower)
    return text


def _from_german(text: str) -> str:
    text = re.sub(r"(?<=\w)-(?=\w)", " ", re.sub(r"(?<=\d),(?=\d)", ".", text))
    text = re.sub(r"\b(\w+spurig) (wird|werden)\b", r"\2 \1", text)
    numbers = {"ein": 1, **_GERMAN_NUMBERS}
    text = re.sub(rf"\b({'|'.join(numbers)})({'|'.join(_GERMAN_COUNTED)})ig(?:e[rsnm]?)?\b", _german_counted, text)
    text = _GERMAN_COMPOUND.sub(lambda m: m[0] if m[0] in _GERMAN_WORDS else f"{m[1]} {m[2]}", text)
    words = {**_GERMAN_WORDS, **{word: str(number) for word, number in _GERMAN_NUMBERS.items()}}
    # Adjectives may carry any ending; they are listed with -e.
    pattern = "|".join(re.escape(w[:-1]) + "(?:e|er|es|en|em)" if w.endswith("ige") else re.escape(w) for w in _longest(words))
    endings = re.compile(r"(?<=ig)(?:er|es|en|em)$")
    return re.sub(rf"\b(?:{pattern})\b", lambda m: words.get(m[0]) or words[endings.sub("e", m[0])], text)


def _german_counted(match: re.Match[str]) -> str:
    """Adjectives of a number: "einspurig", "fünfarmige"."""
    return f"{({'ein': 1} | _GERMAN_NUMBERS)[match[1]]} {_GERMAN_COUNTED[match[2]]}"


def _from_chinese(text: str) -> str:
    digit = f"[{''.join(_CHINESE_DIGITS)}]"
    text = re.sub(rf"双向({digit})(?:条)?车道", lambda m: f" {_CHINESE_DIGITS[m[1]]} lanes in total ", text)
    text = re.sub(rf"(前|后)({digit})个(?:路口)?", lambda m: f" the {_ENDS[m[1]]} {_CHINESE_DIGITS[m[2]]} ", text)
    text = re.sub("第([一二三四五])个(?:路口)?", lambda m: f" the {_ORDINALS[_CHINESE_DIGITS[m[1]]]} ", text)
    text = re.sub("[一二三四五六七八九]?[十百][一二三四五六七八九十]*", _chinese_number, text)
    limit = r"(?:最高|最大)?(?:限速|时速|车速|速度)(?:限制)?(?:为|是|每小时)?"
    text = re.sub(limit + r"(\d+)(?:公里|千米)(?!每|/)", r"限速\1公里每小时", text)
    text = re.sub(rf"单向({digit})(?:条)?车道(?=的?(?:道路|公路|街道|马路|路))", r"单向行驶 \1条车道", text)
    text = re.sub(rf"({digit}|\d)个?(?:路口|岔口|出口|入口|出入口|岔路)的(环岛|转盘|环形交叉口)", _ring_with_arms, text)
    text = re.sub(rf"({digit}|\d)条道?路(?:交叉|相交|交汇|汇合|相遇)的?(?:路口|交叉口)?", _crossing_of_roads, text)
    text = re.sub(rf"(?<![十百千])({digit})(?=公里|千米|米)", lambda m: f" {_CHINESE_DIGITS[m[1]]}", text)
    text = re.sub(rf"({digit}|\d)[行横排][×x乘]?({digit}|\d)[列纵]", _rows_and_columns, text)
    if re.search("环岛|转盘|环形交叉口", text):
        text = re.sub(rf"({digit}|\d)个?(?:出入口|入口|出口|进口|岔口|岔路|岔道)", _arms, text)
    text = re.sub("一条车道", " 1 lane ", text)
    text = re.sub("一个|一条", " ", text)
    text = re.sub(rf"({digit})(?=岔|路交|条|个(?!方向)|车道|臂|路)", lambda m: f" {_CHINESE_DIGITS[m[1]]}", text)
    text = re.sub(r"(?<=\d)[个条]", "", re.sub(r"(\d)条?路(?!交|口)", r"\1 roads ", text))
    pattern = "|".join(re.escape(word) for word in _longest(_CHINESE_WORDS))
    return re.sub(pattern, lambda m: f" {_CHINESE_WORDS[m[0]]} ", text)


def _chinese_number(match: re.Match[str]) -> str:
    """Numbers from ten on: "一百二十" is 120; "十字" (the cross) is none."""
    words = match[0]
    if match.string[match.end() : match.end() + 1] == "字":
        return words
    hundreds, _, rest = words.rpartition("百")
    tens, ten, ones = rest.rpartition("十")
    value = _CHINESE_DIGITS.get(hundreds, 1) * 100 if "百" in words else 0
    value += _CHINESE_DIGITS.get(tens, 1) * 10 if ten else 0
    if ones:
        value += _CHINESE_DIGITS[ones] * (10 if "百" in words and not ten else 1)
    return str(value)


def _rows_and_columns(match: re.Match[str]) -> str:
    rows, columns = (_CHINESE_DIGITS.get(number, number) for number in match.groups())
    return f" {rows} x {columns} "


def _arms(match: re.Match[str]) -> str:
    return f" {_CHINESE_DIGITS.get(match[1], match[1])} arms "


def _crossing_of_roads(match: re.Match[str]) -> str:
    return f" intersection of {_CHINESE_DIGITS.get(match[1], match[1])} roads "


def _ring_with_arms(match: re.Match[str]) -> str:
    return f" roundabout with {_CHINESE_DIGITS.get(match[1], match[1])} arms "


def _longest(words: dict[str, str]) -> list[str]:
    return sorted(words, key=lambda word: (-len(word), word))
