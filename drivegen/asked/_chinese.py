"""Chinese words of traffic, phrase by phrase in English."""

import re

_DIGITS = dict(zip("一二两三四五六七八九", (1, 2, 2, 3, 4, 5, 6, 7, 8, 9), strict=True))
_EGO = "目标车辆|目标车|自动驾驶车辆|自车|主车|本车|我车|我们的车|我们|自身车辆"

SIGN = re.compile(r"[一-鿿]")
VEHICLE = re.compile(rf"车(?!道)|巴士|{_EGO}")
TRAFFIC = re.compile(
    rf"车(?!道)|巴士|大巴|密集|稀疏|拥堵|拥挤|高峰|公里每小时|时速|千米|秒|急刹|切入|加塞|左转|右转|变道|{_EGO}|其中"
)

_OF_US = f"(?:{_EGO})的?"
_BY_US = f"在?(?:{_OF_US})?"
_FRONT, _BACK, _SIDE = "正?(?:前方|前面|前边)", "正?(?:后方|后面|后边|身后)", "(?:侧|边|方|面)"
_CHANGES = "(?:变道|换道|并线|变更车道|变更|并道)"
_CUTS = "(?:切入|插入|并入|变道|换道|并线|加塞|插队|切|插|并)"
_CROSSES = f"(?:横穿|横跨|穿过|越过)(?:{_OF_US})?(?:路径|车道|前方|行驶路线)"
_COMES = "(?:驶来|开来|过来|驶入|驶近|接近|驶出|来)"

_PHRASES = (
    (r"以?(?:大约|约)?(?:每小时|时速)(?:大?约|为)?(\d+)(?:公里|千米)?(?:的速度)?", r" at \1 km/h "),
    (r"在?(?:前|最初)?(\d+)秒钟?(?:之内|以内|内)", r" within \1 seconds "),
    (f"{_BY_US}{_FRONT}向?左转|{_CROSSES}向?左转|左转{_CROSSES}", " turns left across our path "),
    (f"{_CUTS}(?:到|至|进)?{_OF_US}(?:{_FRONT}|车道)", " cuts in "),
    (f"在?{_OF_US}{_FRONT}(?:切入|插入|并入|加塞|插队)", " cuts in "),
    (f"(?:从(?:{_OF_US})?左{_SIDE})?(?:超车|超越|超过)了?(?:{_EGO})?", " overtakes us "),
    (f"(?:向|往)左{_SIDE}?(?:车道)?{_CHANGES}|{_CHANGES}(?:到|至|进入)左{_SIDE}?车?道?|左变道", " changes to the left lane "),
    (f"(?:向|往)右{_SIDE}?(?:车道)?{_CHANGES}|{_CHANGES}(?:到|至|进入)右{_SIDE}?车?道?|右变道", " changes to the right lane "),
    (f"从?(左|右){_SIDE}?的?(?:路口|支路|岔路|道路){_COMES}?", r" coming from the \1 "),
    (f"从(左|右){_SIDE}?{_COMES}", r" coming from the \1 "),
    (f"从(左|右){_SIDE}?车道", r" from the \1 lane "),
    (f"从(左|右){_SIDE}", r" from the \1 "),
    (f"{_BY_US}(左|右)侧?前方", r" ahead on the \1 "),
    (f"{_BY_US}(左|右)侧?后方", r" behind on the \1 "),
    (f"{_BY_US}(左|右){_SIDE}?车道(?:上|内|里)?", r" in the \1 lane "),
    (f"在?{_OF_US}(左|右){_SIDE}|在?(左|右){_SIDE}有?", r" on the \1\2 "),
    (f"在?{_OF_US}{_FRONT}", " ahead of us "),
    (f"(?:跟随|跟着|尾随|紧跟|紧随)在?{_OF_US}(?:{_BACK}|之后)?|在?{_OF_US}{_BACK}", " behind us "),
    (f"在?{_OF_US}(?:旁边|侧面|旁)", " beside us "),
    (r"(?<=[车士])的?(?:后方|后面|后边|前方|前面)(?=有|停|行|是|还)", " beyond "),
    ("(?:排成|排着)?(?:一列|一排|一队|长队|车队)(?:行驶)?|排队|列队|首尾相接|依次排列|一辆接一辆", " in a queue "),
)
_WORDS = {
    "the ego": _EGO.replace("|", " "),
    "around": "周围",
    "nearby": "附近",
    "car": "小汽车 轿车 汽车 小车 跑车",
    "taxi": "出租车",
    "van": "面包车",
    "suv": "越野车",
    "truck": "卡车 大货车 货车 重卡 半挂车 大卡车",
    "bus": "公交车 公共汽车 巴士 大客车 客车 大巴 大巴车 校车",
    "vehicle": "车辆 车",
    "motorbike": "摩托车",
    "moped": "电动车",
    "cyclist": "自行车",
    "pedestrian": "行人",
    "the leading vehicle": "前车 前方车辆 前方的车",
    "the following vehicle": "后车 后方车辆",
    "traffic": "车流 交通 交通流",
    "dense": "密集 拥堵 拥挤 繁忙 高峰",
    "dense traffic": "交通拥堵 交通拥挤 车辆拥挤 车流密集 车流量大 车多 交通密集 交通繁忙 车辆密集 密集车流",
    "traffic jam": "堵车",
    "rush hour traffic": "早高峰 晚高峰 高峰期 高峰时段",
    "sparse traffic": "车少 车流量小 车流稀疏 交通稀疏 车流稀少 车辆稀少 车辆稀疏 稀疏车流",
    "sparse": "稀疏 稀少",
    "medium traffic": "车流中等 交通中等 交通适中 中等车流 正常车流",
    "medium": "中等 适中",
    "oncoming": "对向 迎面 对面 对向车道",
    "oncoming vehicle": "对向车",
    "turns left": "左转弯 左转 向左转 左拐",
    "turns right": "右转弯 右转 向右转 右拐",
    "cuts in": "切入 加塞 插队 强行并线 插入",
    "brakes hard": "急刹车 急刹 紧急制动 紧急刹车 猛踩刹车 急停 猛刹车 突然刹车 急减速 突然急刹车",
    "stopped": "停着 停放 停放着 抛锚 抛锚的 静止 静止的 停止的 停下的 停在 停止 停了",
    "broken down": "故障",
    "ahead": "前方 前面 正前方",
    "behind us": "后方 后面 身后",
    "seconds": "秒",
    "about": "大约 大概 约",
    "km/h": "公里每小时 千米每小时 公里/小时 千米/小时",
    "m/s": "米每秒 米/秒",
    "m": "米",
    "and": "和 以及 并且 并 同时 而 与 还有",
    "1 of them": "其中一辆",
    "": "其中 在 处 有 的 速度 正在 正 距离 处的 着 了",
    "another 1": "另一辆",
    "everybody": "所有车辆 所有车 大家",
    "no": "没有 无",
    "not": "不",
    "at": "以",
    "drives": "行驶",
    "follows": "跟着 跟随",
    "comes": "驶来 开来 来了",
    "suddenly": "突然",
    "several": "几",
    "it": "它",
    "is": "是",
    "lane": "车道",
    "bus lane": "公交车道 公交专用道",
    "left": "左",
    "right": "右",
}
_IN_ENGLISH = {word: english for english, words in _WORDS.items() for word in words.split()}
_SPOKEN = {"left": "left", "right": "right", "左": "left", "右": "right"}


def in_english(clause: str) -> str:
    """A clause in English words, in the order of the Chinese ones; what is not known stays as it is."""
    clause = re.sub(f"([{''.join(_DIGITS)}])?十([{''.join(_DIGITS)}])?", _tens, clause)
    clause = re.sub(f"(?<![其另])([{''.join(_DIGITS)}])(?=[辆台个名秒米])(?!辆接)", lambda m: str(_DIGITS[m[1]]), clause)
    clause = clause.replace("其中1辆", "其中一辆").replace("另1辆", "另一辆")
    for pattern, english in _PHRASES:
        clause = re.sub(pattern, lambda m, e=english: _with_sides(m, e), clause)  # type: ignore[misc]
    clause = re.sub(r"(\d+)[辆台个名]", r" \1 ", clause)
    for word in sorted(_IN_ENGLISH, key=len, reverse=True):
        clause = clause.replace(word, f" {_IN_ENGLISH[word]} ")
    return clause


def _with_sides(match: re.Match[str], english: str) -> str:
    return re.sub(r"\\(\d)", lambda m: _SPOKEN.get(match[int(m[1])] or "", match[int(m[1])] or ""), english)


def _tens(match: re.Match[str]) -> str:
    return str(10 * _DIGITS.get(match[1] or "一", 1) + _DIGITS.get(match[2] or "", 0))
