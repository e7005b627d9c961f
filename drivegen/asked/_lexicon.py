"""The words of traffic, each with its tag and value: what vehicles are called, where they are, what they do.

Words are those of `maps.writers._reading.normalise`: lower case, digits, one-word units, no apostrophes or hyphens. A phrase is
tagged as a whole, and the longest phrase wins.
"""

from drivegen.asked._inflections import verbs
from drivegen.asked._names import Entry, others, phrases, targets, vehicles
from drivegen.asked.request import Density
from drivegen.assets.where import Relation

_PLAIN: dict[str, dict[object, str]] = {
    "DET": {1: "a, an", None: "the, this, that same, these, those", "another": "another, 1 more"},
    "SOME": {4: "several, a handful of", 3: "some, a few, few, a couple more", 2: "both, a couple, a couple of, couple of",
             10: "many, lots of, a lot of, plenty of, numerous"},
    "OUR": {"": "our, my, the ego s, ego s, the target s, target s, the ego vehicle s, the target vehicle s, the ego car s"},
    "ITS": {"": "its, his, her, their"},
    "IT": {1: "it, him, itself", 2: "them, they"},
    "MEMBER": {"": "of them, of these, of those, of which, of whom, of the lot"},
    "OTHERS": {"": "the others, the other 1, the other, the rest, the remaining 1, the rest of them, the other 2"},
    "ORD": {"": "third, fourth, other, different"},
    "MOSTLY": {"": "mostly, mainly, predominantly, chiefly, largely"},
    "SIDE": {"left": "left", "right": "right"},
    "HAND": {"": "hand, side, hand side, flank"},
    "EITHERSIDE": {"": "on either side, on both sides, on each side, either side, to either side, to both sides, both sides"},
    "LANE": {"": "lane, lanes"},
    "INLANE": {"": "same lane, ours"},
    "INCLUDING": {"": "including, incl, incl ., includes, among them, amongst them, among which, inclusive of"},
    "BESIDE": {"": """beside, next to, alongside, alongside of, abreast, abreast of, parallel to, side by side with, level
        with, neck and neck with, flanking"""},
    "AHEAD": {"": """ahead, ahead of, in front, in front of, right in front of, right in front, right ahead, right ahead of,
        at the front, to the front, to the front of, directly ahead, just ahead, just ahead of, up ahead, up front, before,
        right before, just before, down the road, dead ahead, straight ahead, straight ahead of, directly in
        front of, just in front of, immediately ahead of, immediately in front of""",
              "bare": "ahead 0"},
    "BEHIND": {"": """behind, in back of, in the rear, at the rear, to the rear, at the rear of, to the rear of, in the
        back, right behind, directly behind, just behind, close behind, immediately behind, closely behind, in our rear, to
        our rear, to its rear, on our tail, on our bumper, on its tail, on its bumper, on our rear bumper, at our back, at
        our rear, in our mirror, in our mirrors, in the mirror, in the rear view mirror, in our rear view mirror, from
        behind, from the rear, stuck behind, caught behind, trapped behind, on the tail of, on the bumper of, in our wake,
        at our tail, up behind, in the wake of""", "back": """back"""},
    "DIAGONAL": {"": "diagonally, diagonal, obliquely, at an angle"},
    "ONCOMING": {"": """oncoming, on coming, opposing, head on, from the opposite direction, in the opposite direction, from
        the opposite side, from the other direction, in the other direction, in the opposite lane, in the oncoming lane,
        from the oncoming lane, the other way, the opposite way, in the opposing lane, from the opposing direction, on the
        opposite side, from the other side, from the opposite lane, in the contrary direction, the opposite direction, on
        the oncoming side, on the oncoming lane, on the opposite lane, from the front, from ahead, from opposite, opposite
        direction, from in front, on the other side of the road, coming up the other way"""},
    "TOWARDS": {"": "towards, toward"},
    "AROUND": {"": """surrounded by, all around, near, nearby, close to, in the vicinity of, in the vicinity, around here,
        close by, in the surroundings, in total, altogether, all told, overall, everywhere, in the area, in the
        neighbourhood"""},
    "ACROSS": {"": "across, through, crossing, athwart, right across, straight across, right through"},
    "PATH": {"": "path, way, trajectory, course, nose, bonnet, bows, front bumper, route"},
    "IN": {"": "in, on, at, along, within"}, "OF": {"": "of, comprising, consisting of, made up of, composed of"},
    "BY": {"": "by"}, "OFF": {"": "off"}, "UP": {"": "up"},
    "INTO": {"": "into, in to, onto, on to"}, "TO": {"": "to"}, "FROM": {"": "from, out of"},
    "OVER": {"": "over, across to"}, "OUT": {"": "out"}, "PAST": {"": "past, by us"}, "DOWN": {"": "down"},
    "AND": {"": "and, while, whereas, whilst, but, plus, when, then, and then, as well as, as, as soon as, once, if"},
    "OR": {"": "or, or else, or maybe"},
    "WITH": {"": "with, having"},
    "NOT": {"": """no, not, without, never, nobody, none, neither, nor, instead of, rather than, unlike, doesn t, don t, isn
        t, aren t, won t, nothing, without any, excluding, except, avoid, not a single, no other, no 1, refrains from,
        refuses to, 0, fails to, fail to"""},
    "WITHIN": {"": """within, within the first, within the next, inside, inside the first, inside of, in under, in less
        than, in at most, in no more than, after at most, after no more than, after less than, under, in the first, in the
        next, during the first, during the next, no later than, not later than, at the latest after, before, in the space
        of, at most, by, less than, in, over the first, over the next, in fewer than, in the opening, within at most, for at
        most, in the course of the first, within about, within less than, no more than, not more than, after at the most,
        within a maximum of, in a maximum of, at latest after, within just, within only, within roughly"""},
    "BOUND": {"": "at least, up to, no fewer than, no less than, at the most, more than, fewer than, a maximum of"},
    "LENGTH": {"": "car length, car lengths, vehicle length, vehicle lengths, truck lengths, truck length, bus lengths"},
    "APPROX": {"": """about, around, roughly, approximately, circa, ca, some, only, just, approx, nearly, almost, close to,
        a bit over, exactly, at about, at around, at roughly, at approximately, at some, at, a distance of, at a distance
        of, a speed of, at a speed of, speed of, at a steady, at a constant, at a gap of, with a gap of, a gap of, gap of,
        doing, of about, by, at speeds of, speeds of, with a distance of, in a distance of, at speeds around, at speeds of
        about, at a speed of about, at speeds of around, speeds around, at only, at just, at an average of, at a distance of
        about, t"""},
    "AWAY": {"": """away, off, away from, distant, of distance, distance, of us, from us, from the ego, from the target,
        gap, out, of headway, clear of"""},
    "METRE": {1.0: "m", 0.3048: "ft", 0.9144: "yd"},
    "SPEEDUNIT": {1 / 3.6: "kmh, km h", 0.44704: "mph", 1.0: "mps"},
    "SECOND": {"": "s, sec, secs, second, seconds"},
    "HALF": {"": "half, half a, half of"},
    "HARD": {"": """hard, sharply, suddenly, heavily, abruptly, violently, emergency, panic, sudden, abrupt, sharp, full,
        fully, harshly, harsh, fiercely, forcefully, all of a sudden, with full force, at full force, strongly, severely,
        severe, strong, very hard, extremely hard, as hard as it can, really hard, aggressively, violent, unexpectedly,
        brutally, firmly, full on, out of nowhere, without warning, to a dead stop, like mad, as hard as possible,
        drastically, massively"""},
    "HEAVY": {"": "heavy"}, "LIGHT": {"": "light"},
    "GENTLY": {"": "gently, softly, slightly, smoothly, mildly, gradually, lightly, gentle, soft, slight, a little"},
    "ADV": {"": """quickly, slowly, fairly, rather, pretty, extremely, somewhat, relatively, directly, straight, just,
        immediately, shortly, closely, very, quite, really, also, again, now, still, tightly, narrowly, recklessly, swiftly,
        rapidly, right now, only, already, there, too, once more, eventually, soon, promptly, dangerously, cheekily, fast,
        at speed, at high speed, at full speed, both, briefly, boldly, simply, rudely, carelessly, completely, smartly,
        neatly, at once"""},
    "GAP": {"": "the gap, a gap, the space, the small gap, the tiny gap, the narrow gap, our gap, the hole"},
    "FURTHER": {"": "further, farther, more, another"},
    "DENSE": {Density.DENSE: """dense, congested, crowded, jammed, busy, thick, packed, densely packed, closely packed, rush
        hour, tightly packed, gridlocked, bumper to bumper, stop and go, chock a block, peak hour, nose to tail, high
        density, slow moving, jam packed, very dense, much, lots of, a lot of, plenty of, clogged, backed up, saturated,
        peak time, stop start""",
              Density.MEDIUM: """medium, moderate, normal, average, ordinary, medium density, moderately dense, usual,
        typical, regular, moderately busy, moderately heavy, moderately packed, middling""",
              Density.SPARSE: """sparse, thin, little, low density, low, free flowing, very little, hardly any, barely any,
        scarcely any, almost no, next to no, not much, scant, sparsely populated, quiet, minimal, very sparse, very light,
        scarce, barely, free flow, thinly spread"""},
    "JAM": {Density.DENSE: "traffic jam, gridlock, congestion, rush hour, heavy congestion, a jam, jam packed road"},
    "DENSITY": {"": "density, traffic density, traffic volume, volume"},
    "TRAFFIC": {"": "traffic, road traffic"},
    "ALL": {"them": "all, all of them, all of these, both of them, each of them, they all",
            "": """everyone, everybody, all vehicles, all cars, all of them, all of us, everything, all traffic, all
        other vehicles, all the vehicles, all the cars, all the traffic, all the others, surrounding traffic, the other
        vehicles, the other cars, the others all, each of them, everyone else, every vehicle, every car, all other cars, the
        rest of the traffic, the flow, surrounding vehicles, the surrounding vehicles, the traffic around us, the other
        traffic, they all"""},
    "QUEUE": {"": """queue, line, column, row, convoy, platoon, string, file, chain, procession, single file, queue
        up, caravan, cortege, tailback"""},
    "QUEUED": {"": """queued, queueing, queuing, queued up, queueing up, lined up, lining up, line up, queue up, nose to
        tail, in tandem, 1 behind another, 1 behind the other, 1 after another, 1 after the other, 1 behind the next, bumper
        to bumper, in single file, back to back, platooning, strung out, in convoy, in formation, 1 following the other, in
        file, stacked up, end to end, in line, in procession, 1 following another, behind 1 another, behind each other, 1 by
        1"""},
    "STANDING": {"": """stopped, stationary, parked, double parked, broken down, stalled, immobile, standing, standing
        still, stands, stand, stands still, at a standstill, halted, disabled, abandoned, stuck, not moving, doesn t move,
        motionless, does not move, isn t moving, stranded, at rest, breaks down, broke down, break down, breaking down, has
        stalled, sits still, dead, idle, at a halt, at a stop, immobilised, immobilized, unmoving, defective, has stopped,
        standstill, is not moving, parking, sits motionless, sitting still, at zero speed, with a flat tyre, fails to move,
        is broken, crippled, at a complete stop"""},
    "LEADING": {Relation.AHEAD: "lead, leading, front, preceding, vorausfahrend", Relation.BEHIND: """rear, following,
        trailing, tailing"""},
    "BE": {"": """is, are, be, being, was, were, gets, get, has, had, been, should be, shall be, will, will be, should,
        shall, must be, re, there is, there are, there s, must, can, may, would, does, do, is to, are to, has to, begins to,
        starts to, suddenly starts to, to, gets, becomes, ve, suddenly has to, needs to, decides to, tries to, is about to,
        wants to"""},
    "REL": {"": "that, which, who, whose"},
    "MAKE": {"": "make, have, let, makes, turn 1, set"},
    "SIDEROAD": {"": """side road, side street, cross street, cross road, minor road, street, road, crossroad, side roads,
        arm, crossing road, crossing street, junction arm, approach"""},
    "CHANGE": {"": "lane change, change of lane, change of lanes, lane changes, lane shift, lane switch, lane changing"},
    "MANOEUVRE": {"": "manoeuvre, maneuver, manoeuvres, maneuvers, event, situation, scenario"},
}  # fmt: skip

_VERBS: dict[str, dict[object, str]] = {
    "CUT": {"": "cut"},
    "SLIP": {"": """squeeze, nip, slot, barge, push, nose, dive, slip, dart, swerve, force, muscle, wedge, edge, shove,
        jump, butt, sneak, duck, push its way, force its way, squash, cram, insert, insert itself, thread, bully, elbow"""},
    "MOVE": {"": """merge, pull, move, change, switch, veer, drift, shift, slide, steer, swing, swap, cross over,
        transition, sidle, lane change, filter, weave, wander, jink, slew, hop, sweep, migrate, budge"""},
    "GO": {"": "go, head, bear, drive off, peel, proceed"},
    "TURN": {"": "turn, swing round, steer off, hook"},
    "TAKE": {"": "take, make, hang, do, perform, execute, carry out, complete, initiate, undertake a, start, begin, conduct"},
    "BRAKE": {"": "brake, decelerate, slow, slow down, reduce speed, lose speed"},
    "SLAM": {"": """slam, slam on, stamp, stamp on, stomp, stomp on, jump on, step on, stand on, hit, hammer, jam on, smash,
        mash, slam down, bang on, slap on, pound, tread on, lean on, jam, throw on"""},
    "STOP": {"": "stop, halt, come to a stop, come to a halt, come to a standstill, pull up, freeze"},
    "SCREECH": {"": "screech to a halt, screech to a stop, skid to a halt, grind to a halt, emergency brake, emergency stop, "
                    "panic brake, panic stop, brake check"},
    "OVERTAKE": {"": "overtake, undertake, outstrip, leapfrog, get ahead of"},
    "PASS": {"": "pass, overhaul"},
    "DRIVE": {"": """drive, travel, run, speed, race, zoom, shoot, rush, roll, cruise, sit, wait, cruise along, ride, blast,
        barrel, creep, crawl, trundle, flow, fly, thunder, roar, whizz, hurtle, hurry, dash, blow, stream, tear, breeze,
        drone, storm, ease, amble, move along, keep, stay, occupy, do, average"""},
    "FOLLOW": {"": "follow, tailgate, tail, trail, chase, hug, shadow, hang on to, stick to, dog, pursue, stalk"},
    "PRECEDE": {"": "precede, lead"},
    "LEAVE": {"": "leave, quit, vacate"},
    "COME": {"": "come, approach, arrive, enter, emerge, appear, come in, close in, come up, come along, join, exit"},
    "CROSSES": {"": "cross"},
    "BLOCK": {"": "block, obstruct, bar, blockade, impede"},
    "SURROUND": {"": "surround, encircle"},
}  # fmt: skip


def _lexicon() -> dict[tuple[str, ...], Entry]:
    """All phrases; of those that are listed twice the first counts, but for vehicles and the target."""
    plain = {phrase: (tag, value) for tag, row in reversed(_PLAIN.items()) for value, text in reversed(row.items())
             for phrase in reversed(phrases(text))}  # fmt: skip
    spoken = {form: (tag, form) for tag, row in reversed(_VERBS.items()) for text in reversed(row.values())
              for phrase in reversed(phrases(text)) for form in verbs(phrase)}  # fmt: skip
    found: dict[str, Entry] = {**others(), **spoken, **plain, **vehicles(), **targets()}
    return {tuple(phrase.split()): entry for phrase, entry in found.items()}


LEXICON = _lexicon()
LONGEST = max(map(len, LEXICON))
