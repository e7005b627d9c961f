"""Chinese descriptions, word by word in English."""

import re

from drivegen.maps.writers._lexicon import longest

_CHINESE_DIGITS = dict(zip("一二两三四五六七八九", (1, 2, 2, 3, 4, 5, 6, 7, 8, 9), strict=True))
_ENDS = {"前": "first", "后": "last"}
_RING = "环岛|转盘|环形交叉口|环形路口"
_MEET = (
    "(?:相?交叉|相交|交汇|汇合|相遇|汇集|汇聚|汇入|相接|会合)(?:于|在|到|成|形成)?(?:此|这里|同?一个?|一处|一点)?的?(?:大型|大)?"
    "(?:十字路口|十字交叉口|平面交叉口|路口|交叉口|处|点)?"
)
_ORDINALS = ("", "first", "second", "third", "fourth", "fifth")
_CHINESE_WORDS = {
    "米后": "m later", "公里后": "km later", "错位交叉口": "staggered junction", "十字路口": "4 way intersection",
    "十字交叉口": "4 way intersection", "丁字路口": "t junction", "T型路口": "t junction", "T形路口": "t junction",
    "T字路口": "t junction", "Y型路口": "y junction", "Y形路口": "y junction", "岔路口": " way intersection",
    "路交叉口": " way intersection", "环形交叉口": "roundabout", "环岛": "roundabout", "转盘": "roundabout",
    "交叉口": "intersection", "路口": "intersection", "高速公路": "highway", "高速路": "highway", "快速路": "expressway",
    "入口匝道": "on ramp", "上匝道": "on ramp", "出口匝道": "off ramp", "下匝道": "off ramp", "匝道": "ramp",
    "红绿灯": "traffic lights", "信号灯": "traffic lights", "交通灯": "traffic lights", "信号控制": "signalised",
    "没有": "without", "减到": "narrows to", "先减到": "to", "先减为": "to", "先增加到": "to", "再": ", then", "由": "from",
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
    "增加到": "widens to", "增加为": "widens to", "变成": "to", "扩宽": "widens",
    "右侧": "right", "左侧": "left", "先": "first", "后": ",",
    "弯道": "curve", "弯路": "curved road", "弯曲": "curved", "S形弯": "s curve", "S弯": "s curve", "S型弯": "s curve",
    "发夹弯": "hairpin", "网格": "grid", "棋盘": "grid", "单行道": "one way street", "断头路": "cul de sac",
    "死胡同": "cul de sac", "道路": "road", "公路": "road", "街道": "street", "马路": "road", "乡村": "rural", "城市": "urban",
    "住宅区": "residential", "主路": "main road", "主干道": "main road", "支路": "side road", "停车标志": "stop signs",
    "让行": "yield", "变为": "to", "减少到": "narrows to", "减为": "narrows to", "减少为": "narrows to", "减至": "narrows to",
    "增至": "widens to", "增为": "widens to", "变至": "to", "缩减为": "narrows to", "从": "from", "出口": " exits", "臂": " arms",
    "靠左行驶": "left hand traffic", "左行": "left hand traffic", "直径": "diameter", "相距": "spaced", "度": "degrees",
    "向左": "to the left", "向右": "to the right", "分叉": "fork", "左转车道": "left turn lanes",
    "右转车道": "right turn lanes", "和": "and", "，": ",", "。": ".", "、": ",", "的": ",", "一个": "a ", "一条": "a ",
    "双向道路": "2 way road", "消失": "ends", "结束": "ends", "最右侧": "right", "最左侧": "left", "错开": "offset",
    "入口": " entrances", "双向通行": "2 way traffic", "单向高速公路": "one way highway", "单向快速路": "one way expressway",
    "之后变为": ", then", "之后为": ", then", "然后变为": ", then",
    "分岔成": "splits into", "分岔": "splits", "之后": ", then", "两支": "2 branches", "转": "turns",
    "双向行驶": "2 way traffic", "弯": "bend", "与": "and", "住宅小区": "residential", "小区": "residential", "十字交叉": "cross",
    "左侧通行": "left hand traffic", "右侧通行": "right hand traffic", "依次": "in a row", "四个方向": "on all arms",
    "最后一个": "the last",
    "长": "long", "每个": "each", "连成一排": "in a row", "一排": "in a row", "棋盘式路网": "grid", "路网": "grid",
    "左转专用车道": "left turn lanes", "右转专用车道": "right turn lanes", "各进口": "on every approach",
    "各进口道": "on every approach", "每个进口道": "on every approach", "均": "all", "都": "all", "设有": "with",
    "设置": "with", "设": "with", "相交": "cross", "无灯控": "unsignalised", "让行标志": "yield signs",
    "停车标志控制": "stop signs", "全向停车": "all way stop", "环形路口": "roundabout",
    "苜蓿叶形立交": "cloverleaf", "苜蓿叶立交": "cloverleaf", "苜蓿叶": "cloverleaf", "部分苜蓿叶": "partial cloverleaf",
    "半苜蓿叶": "partial cloverleaf", "喇叭形立交": "trumpet", "喇叭立交": "trumpet", "喇叭形": "trumpet", "立交": "interchange",
    "部分苜蓿叶立交": "partial cloverleaf", "环形匝道": "loop ramp", "环形出口匝道": "loop off ramp",
    "为": "is", "起点": "start", "终点": "end", "距离": "distance", "之间": "between",
}  # fmt: skip


def from_chinese(text: str) -> str:
    """A text with the Chinese words that are known replaced."""
    digit = f"[{''.join(_CHINESE_DIGITS)}]"
    text = re.sub(rf"双向({digit})(?:条)?车道", lambda m: f" {_CHINESE_DIGITS[m[1]]} lanes in total ", text)
    text = re.sub(rf"(前|后)({digit})个(?:路口)?", lambda m: f" the {_ENDS[m[1]]} {_CHINESE_DIGITS[m[2]]} ", text)
    text = re.sub("两侧各有一条(?:支路|小路|街道)", " 2条支路 on opposite sides ", text)
    straight = "(?:的|是|为|有|一段|长)*(?:直线|直路|直道|直段)(?:段|道路|路段)?(?:长)?"
    text = re.sub(rf"前后(?:各|均|都)(?:{straight})?(\d+)米(?:{straight})?", r" ，\1米 straight on each side ", text)
    text = re.sub("[：；（）]", "，", text)
    text = re.sub("(?<=[，,、])单向(?=[，,。])", "单向行驶", text)
    text = re.sub(r"(?:在)?(\d+)(米|公里|千米)处(?:有|设有|设)?", r" , at \1\2 with ", text)
    text = re.sub(r"(?:再过|再往前|继续)(\d+)(米|公里|千米)(?:后|处)?", r" , \1\2后", text)
    text = re.sub(r"(?:起点后|距起点|离起点)(\d+)(米|公里|千米)(?:处)?", r" , \1\2 from the start ", text)
    text = re.sub(r"前(\d+)(?=米|公里|千米)", r" for the first \1", text)
    text = re.sub("第([一二三四五])个(?:路口)?", lambda m: f" the {_ORDINALS[_CHINESE_DIGITS[m[1]]]} ", text)
    text = re.sub("[一二三四五六七八九]?[十百][一二三四五六七八九十]*", _chinese_number, text)
    limit = r"(?:最高|最大)?(?:限速|时速|车速|速度)(?:限制)?(?:为|是|每小时)?"
    text = re.sub(limit + r"(\d+)(?:公里|千米)(?!每|/)", r"限速\1公里每小时", text)
    text = re.sub(rf"单向({digit})(?:条)?车道(?=的?(?:道路|公路|街道|马路|路))", r"单向行驶 \1条车道", text)
    text = re.sub(rf"({digit}|\d)个?(?:路口|岔口|出口|入口|出入口|岔路)的(环岛|转盘|环形交叉口)", _ring_with_arms, text)
    text = re.sub(rf"({digit}|\d)(?:岔路?|路|臂|条路)的?(?:口的?)?(环岛|转盘|环形交叉口)", _ring_with_arms, text)
    meeting = _arms if re.search(_RING, text) else _crossing_of_roads
    text = re.sub(
        rf"([三四五六七八九3-9])条(?:\w{{0,4}}?)(?:道路|路|街道|街|马路|公路)(?:在此|同时|都|均)?{_MEET}", meeting, text
    )
    text = re.sub(rf"({digit}|\d)(?:岔|叉)(?:路)?口", _crossing_of_roads, text)
    if re.search(_RING, text):
        text = re.sub(rf"(?:连接|接入|接)(?:着|了)?({digit}|\d)条(?:道路|路|街道|马路|公路)", _arms, text)
    text = re.sub(rf"(?<![十百千])({digit})(?=公里|千米|米)", lambda m: f" {_CHINESE_DIGITS[m[1]]}", text)
    text = re.sub(rf"({digit}|\d)[行横排][×x乘]?({digit}|\d)[列纵]", _rows_and_columns, text)
    if re.search(_RING, text):
        text = re.sub(rf"({digit}|\d)个?(?:出入口|入口|出口|进口|岔口|岔路|岔道)", _arms, text)
    text = re.sub("一条车道", " 1 lane ", text)
    text = re.sub("一个|一条", " ", text)
    text = re.sub(rf"({digit})(?=岔|路交|条|个(?!方向)|车道|臂|路)", lambda m: f" {_CHINESE_DIGITS[m[1]]}", text)
    text = re.sub(r"(?<=\d)[个条]", "", re.sub(r"(\d)条?路(?!交|口)", r"\1 roads ", text))
    pattern = "|".join(re.escape(word) for word in longest(_CHINESE_WORDS))
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
