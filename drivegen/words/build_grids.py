"""From a scene to a grid of streets."""

import math

from drivegen.words.build_crossings import control_of
from drivegen.words.build_rows import spacing_of
from drivegen.words.choices import Choices, is_one_way, lanes_of, speed_of, usual_speed
from drivegen.words.things import Road, Scene, Unfit


def grid(scene: Scene, choices: Choices) -> Road:
    """Streets that cross in rows and columns."""
    scene.one_road("grid")
    scene.one_road("street", "main")
    whole = scene.merged("grid", "street", "crossing")
    sizes, spacing = {*whole.values("grid_size"), *(pair[::-1] for pair in whole.values("columns_rows"))}, spacing_of(whole, [])
    blocks = whole.values("grid_blocks")
    if any(0 in pair for pair in blocks):
        raise Unfit("a grid has a block at least")
    sizes |= {(rows + 1, columns + 1) for rows, columns in blocks}
    crossings = {count for thing in scene.named("crossing") for count in thing.values("count")}
    if any(arms != 4 for arms in whole.values("arms")):
        raise Unfit("crossings of a grid have four arms")
    sizes = sizes or {(side, side) for side in map(math.isqrt, crossings) if side**2 in crossings}
    if len(sizes) > 1 or set(whole.values("count")) - {rows * columns for rows, columns in sizes}:
        raise Unfit("say the grid as rows by columns of crossings, e.g. '3 by 4'")
    rows, columns = sizes.pop() if sizes else (3, 3)
    one_way = is_one_way(whole)
    lanes = lanes_of(whole, one_way=one_way, arms=True) or (1, 1)
    if lanes[0] != lanes[1] and not one_way:
        raise Unfit("the streets of a grid have the same lanes in both directions")
    fields = {"kind": "grid", "rows": rows, "columns": columns, "lanes": lanes[0], "one_way": one_way}
    fields |= {"spacing": spacing or choices.length("spacing", 100, 150), "beyond": whole.value("beyond")}
    return fields | {"speed": speed_of(whole) or usual_speed([whole]), "control": control_of(whole, True)}
