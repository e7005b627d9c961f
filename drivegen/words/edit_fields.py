"""What an edit says of one thing, put into the fields of a specification that it means."""

import math

from drivegen.layouts.highways import HighwayEvent
from drivegen.words.build_crossings import check_turns, turning
from drivegen.words.build_events import AUXILIARY, EVENTS, SHORTEST
from drivegen.words.choices import lanes_of
from drivegen.words.slots import SLOTS
from drivegen.words.things import Road, Thing, Unfit

_RAMPS = ("on_ramp", "off_ramp", "weaving")
_NO_TURN_LANES = {"left_turn_lanes": 0, "right_turn_lanes": 0}
_LANES = {"side": ("side_lanes", "lanes_in", "lanes_out"), "ring": ("ring_lanes",), "upper": ("road_lanes",)}
_LANES |= {"left_branch": ("left_lanes",), "right_branch": ("right_lanes",)}
_LANES |= dict.fromkeys(("cross", "crossing", "roundabout"), ("side_lanes",))
_LENGTHS = ("leg_length", "road_length", "side_length", "length")
_OF_THE_ROAD = ("diameter", "spacing", "median", "lane_width", "ring_lanes", "ring_speed")
_BEHIND = 150.0
"""So much road [m] is left behind the last that happens along it."""
_SLOW = ("ring_speed", "ramp_speed", "loop_speed", "road_speed")


class Edit:
    """What is said of one thing, put into the fields that it means."""

    def __init__(self, fields: Road, thing: Thing) -> None:
        self.fields, self.road, self.thing = fields, fields["road"], thing
        self.kind = self.road["kind"]

    def run(self) -> None:
        """Set every fact of the thing. Raises Unfit where one fits nowhere."""
        name = self.thing.name
        if name in EVENTS and self.thing.value("remove"):
            self._remove(name)
            return
        become = "roundabout" if name == "roundabout" and self.kind == "crossing" and not self.thing.definite else None
        if (form := self.thing.value("form") or become) is not None:
            self._form(form)
        new = name in EVENTS and not self.thing.definite and not self.thing.has("downstream", "upstream")
        parts = [self._added(name)] if new else self._parts(name)
        self._changes_of_lanes()
        if name and name != "crossing" and not parts:
            which = f"{SLOTS['nth'].speak(self.thing.which)} " if isinstance(self.thing.which, int) else ""
            raise Unfit(f"this road has no {which}{self.thing.text!r}")
        self._lanes(parts)
        self._lanes_in_and_out(parts)
        self._speed(parts, name)
        self._control()
        self._turn_lanes(parts, name)
        self._lengths(parts)
        self._moved(parts)
        self._numbers(parts)

    def _parts(self, name: str) -> list[Road]:
        """The fields that hold what is said of a thing of this name."""
        road = self.road
        arms: list[Road] = road.get("arms", [])
        if name in EVENTS:
            return self._named_events(name)
        if arms:
            which = self.thing.which
            even = self.kind == "crossing" and all(a["main"] for a in arms)
            some = {
                "main": [a for a in arms if a["main"] and not even],
                "side": [a for a in arms if not a["main"]],
                "ring": [road],
            }
            if isinstance(which, float):
                some["arm"] = [a for a in arms if abs(math.remainder(a["angle"] - which, 360.0)) < 1.0]
            return self.thing.among(some.get(name, arms if name in ("", "street", "arm", "crossing", "roundabout") else []))
        if name in ("side", "cross"):
            return self.thing.among(list(road.get("junctions", [])))
        if name in ("crossing", "roundabout"):
            return self.thing.among([j for j in road.get("junctions", []) if j["form"] == name])
        fits = name in ("", "street", "main", self.kind) or (name == "highway" and self.kind != "corridor")
        return [road] if fits or name in ("upper", "left_branch", "right_branch") else []

    def _named_events(self, name: str) -> list[Road]:
        kinds = _RAMPS if name == "ramp" else (name,)
        found = self.thing.among([event for event in self.road.get("events", []) if event["kind"] in kinds])
        if len(found) > 1 and self.thing.definite and self.thing.which is None and not self.thing.text.endswith("s"):
            raise Unfit(f"there are several: say which {self.thing.text!r} is meant")
        return found

    def _events(self) -> list[Road]:
        if self.kind != "highway":
            raise Unfit("only motorways have ramps and lane changes along them")
        events: list[Road] = self.road["events"]
        return events

    def _ramps(self) -> list[Road]:
        return [event for event in self.road.get("events", []) if event["kind"] in _RAMPS]

    def _remove(self, name: str) -> None:
        events, gone = self._events(), self._named_events(name)
        if not gone:
            raise Unfit(f"there is no {self.thing.text!r} along this road")
        self.road["events"] = [event for event in events if event not in gone]

    def _added(self, name: str) -> Road:
        """A new ramp or change of lanes, where it is said to be, else behind all that is there."""
        events = self._events()
        if name == "ramp":
            raise Unfit("say whether it is an on-ramp or an off-ramp")
        last = max((event["position"] + event["length"] for event in events), default=130.0)
        position, lane = self.thing.value("position") or last + 120.0, AUXILIARY.get(name, 0.0)
        if name == "off_ramp":  # it is said to be where it leaves
            lane = max(SHORTEST, min(lane, position - SHORTEST)) if self.thing.has("position") else lane
            position -= lane if self.thing.has("position") else 0.0
        usual = HighwayEvent.model_construct(kind=name, position=position).model_dump(mode="json", exclude={"side"})
        new: Road = usual | ({"length": lane} if lane else {})  # its side is the outer one, unless it is said
        self.road["events"] = sorted([*events, new], key=lambda event: event["position"])
        line = self.road["alignment"]
        line["length"] = max(line["length"], position + lane + _BEHIND)
        return new

    def _changes_of_lanes(self) -> None:
        """Lanes that end or begin at a place that is said; "add a lane" is one more all along."""
        for name, kind in (("loses", "lane_drop"), ("gains", "lane_gain")) if self.thing.has("position") else ():
            for value in (*self.thing.values(name), *self.thing.values(f"{name}_side")):
                self._added(kind).update({"side": value} if isinstance(value, str) else {"lanes": int(value)})

    def _form(self, form: str) -> None:
        road = self.road
        if form == "roundabout" and self.kind == "crossing":
            arms = [{**arm, **_NO_TURN_LANES, "turn_bans": (), "main": True, "angle": arm["angle"] % 360} for arm in road["arms"]]
            usual = 2 if max(arm["lanes_in"] for arm in arms) > 1 else 1
            ring = self.thing.value("lanes", "lane_road", "ring_lanes") or usual
            diameter = max(30.0 + 10.0 * ring, 9.0 * len(arms) + 8.0 * ring)
            self.fields["road"] = {"kind": "roundabout", "arms": arms, "ring_lanes": ring, "diameter": diameter}
        elif form == "crossing" and self.kind == "roundabout":
            self.fields["road"] = {"kind": "crossing", "arms": road["arms"]}
        elif road.get("junctions"):
            for junction in road["junctions"]:
                junction |= {"form": form, "control": "yield", "turn_bans": (), "side_turn_bans": (), **_NO_TURN_LANES}
        else:
            raise Unfit(f"a {self.kind.replace('_', ' ')} cannot become a {form}")
        self.road = self.fields["road"]
        self.kind = self.road["kind"]

    def _lanes(self, parts: list[Road]) -> None:
        more, fewer = self.thing.value("more_lanes"), self.thing.value("fewer_lanes")
        highway = self.kind == "highway"
        one_way = self.road.get("lanes_back") == 0 or self.kind == "fork" or self.road.get("one_way", False)
        one_way = one_way or self.road.get("carriageways") == 1 or self.thing.name == "ring"
        lanes = lanes_of(self.thing, one_way=one_way, per_carriageway=highway, arms=bool(self.road.get("arms")))
        if more is None and fewer is None and lanes is None:
            return
        for part in parts:
            for name in _LANES.get(self.thing.name, ("lanes", "lanes_back", "lanes_in", "lanes_out")):
                if part.get(name) == 0 and self.thing.has("lanes_each"):
                    raise Unfit("a one-way road has no lanes in the other direction")
                if not (value := part.get(name)):
                    continue
                if value <= (fewer or 0):
                    raise Unfit("so many lanes are not there in each direction")
                number = lanes[0] if lanes else value + (more or 0) - (fewer or 0)
                part[name] = number if name not in ("lanes_back", "lanes_out") or not lanes else (lanes[1] or lanes[0])

    def _lanes_in_and_out(self, parts: list[Road]) -> None:
        for way in ("lanes_in", "lanes_out"):
            value = self.thing.value(way)
            if value is not None and not any(way in part for part in parts):
                raise Unfit("no lanes lead in and out here")
            for part in parts if value is not None else ():
                part[way] = value

    def _speed(self, parts: list[Road], name: str) -> None:
        if (speed := self.thing.value("speed", "ramp_speed")) is None:
            return
        said = next((fact.text for fact in self.thing.facts if fact.name == "ramp_speed"), None)
        ramps = self._ramps() if said else []
        if said and len(ramps) > 1 and not said.endswith("s"):
            raise Unfit(f"there are several ramps: {said!r} can be of any of them")
        own = {"side": "side_speed", "cross": "side_speed", "ring": "ring_speed", "upper": "road_speed"}
        for part in ramps or parts:
            names = ("ramp_speed",) if said else (own.get(name, ""), "speed", "ramp_speed")
            fields = [field for field in names if field in part]
            if not fields:
                raise Unfit("no limit can be set there")
            part[fields[0]] = speed
        if name in ("", "street") and not said:
            for junction in self.road.get("junctions", []):
                junction["side_speed"] = speed
            self.road |= {slow: min(self.road[slow], speed) for slow in _SLOW if slow in self.road}

    def _control(self) -> None:
        control, signals = self.thing.value("control"), self.thing.value("signals")
        if control is None and signals is None:
            return
        if self.kind != "corridor" and self.thing.which not in (None, "all"):
            raise Unfit("lights and signs of single arms or junctions of this road cannot be drawn")
        if control == "stop_sign":
            mains = [arm["main"] for arm in self.road.get("arms", [])]
            control = "all_way_stop" if (mains and all(mains)) or self.kind == "grid" else "stop"
        rows = [part for part in self._parts("crossing") if part.get("form") == "crossing"]
        places = rows if self.kind == "corridor" else [self.road]
        if not places or any(place.get("control") is None or place.get("kind") == "roundabout" for place in places):
            raise Unfit("this road has no crossing that could be controlled")
        for place in places:
            place["control"] = control or "yield"

    def _turn_lanes(self, parts: list[Road], name: str) -> None:
        texts = [fact.text for fact in self.thing.facts if fact.name == "no_turn_lanes"]
        sides = [side for side in ("left", "right") if any(side in text for text in texts)]
        none = {f"{side}_turn_lanes": 0 for side in sides or ("left", "right")} if self.thing.value("no_turn_lanes") else {}
        rows = parts if name in ("crossing", "roundabout") else self.road.get("junctions", [])
        rows = [part for part in rows if part.get("form") != "roundabout"]  # rings have neither turn lanes nor bans
        new = turning([self.thing], {"left_turn_lanes": 1}, "turn_bans") | none
        for which in ("main", "side"):
            for side in self.thing.values(f"{which}_turn_bans"):
                field = "side_turn_bans" if which == "side" and self.kind == "corridor" else "turn_bans"
                for part in rows if self.kind == "corridor" else self._parts(which):
                    part[field] = sorted({*part[field], side})
        if not new:
            return
        holders = rows if self.kind == "corridor" else parts
        holders = [part for part in holders if "left_turn_lanes" in part]
        if not holders or self.kind == "roundabout" or (self.kind == "corridor" and name == "side"):
            raise Unfit("there is nothing here that could have turn lanes")
        for part in holders:
            if set(new) == {"pocket"} and not (part["left_turn_lanes"] or part["right_turn_lanes"]):
                raise Unfit("there are no turn lanes whose length could be set")
            part |= new | ({"turn_bans": sorted({*part["turn_bans"], *new["turn_bans"]})} if "turn_bans" in new else {})
            if name == "arm":
                check_turns(self.road["arms"], part, self.thing)

    def _lengths(self, parts: list[Road]) -> None:
        length, longer, shorter = self.thing.value("length"), self.thing.value("longer"), self.thing.value("shorter")
        step = (longer or 0.0) - (shorter or 0.0)
        for part in parts if length is not None or step else []:
            line = part.get("alignment", part)
            name = next((field for field in _LENGTHS if field in line), None)
            if name is None:
                raise Unfit("there is no length here that could be set")
            line[name] = length if length is not None else line[name] + step

    def _moved(self, parts: list[Road]) -> None:
        if (straight := self.thing.value("straight")) and "alignment" in self.road:
            self.road["alignment"] = {"shape": "straight", "length": float(round(self.road["alignment"]["length"]))}
        elif straight:
            raise Unfit("there is no bend here")
        moved = (self.thing.value("downstream") or 0.0) - (self.thing.value("upstream") or 0.0)
        everything: list[Road] = self.road.get("events") or self.road.get("junctions") or []
        these = [i for i, one in enumerate(everything) if any(one is part for part in parts)] if moved else []
        for i in these:
            everything[i]["position"] += moved
        if these:
            line = self.road["alignment"]
            line["length"] = max(line["length"], everything[-1]["position"] + everything[-1].get("length", 0.0) + _BEHIND)
        elif moved:
            raise Unfit("there is nothing along this road that could be moved")

    def _numbers(self, parts: list[Road]) -> None:
        own = self.thing.which is not None or self.thing.name in ("main", "side", "cross", "arm")
        if own and any(self.thing.has(name) for name in ("lane_width", "median", "spacing")):
            raise Unfit("this can be said of the whole road only")
        fields = {"auxiliary": "length", "keeps": "keeps", "position": "position"}
        for name, field in {**fields, **{name: name for name in _OF_THE_ROAD}}.items():
            only_ramp = self._ramps() if name == "auxiliary" and not self.thing.name and len(self._ramps()) == 1 else None
            those = only_ramp or (parts if name in fields else [self.road])
            holders = [part for part in those if field in part]
            if holders and (value := self.thing.value(name)) is not None:
                for part in holders:
                    lane = part["length"] if name == "position" and part.get("kind") == "off_ramp" else 0.0
                    part[field] = value - lane if lane else value
