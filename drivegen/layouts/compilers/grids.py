"""Street grids: rows and columns of streets that go on beyond the outermost crossings."""

from itertools import pairwise

from drivegen.layouts.compilers.crossings import MAIN, NODE_TYPES
from drivegen.layouts.streets import Grid
from drivegen.sumo.plain import Edge, Node, PlainNetwork


def compile_grid(spec: Grid, plain: PlainNetwork) -> None:
    """Draw the grid with its south-west crossing at (0, 0); one-way streets alternate in direction."""
    for row in range(spec.rows):
        _street(spec, plain, [_place(row, column) for column in range(-1, spec.columns + 1)], odd=row % 2 == 1)
    for column in range(spec.columns):
        _street(spec, plain, [_place(row, column) for row in range(-1, spec.rows + 1)], odd=column % 2 == 1)
    for row in range(-1, spec.rows + 1):
        for column in range(-1, spec.columns + 1):
            crossing = 0 <= row < spec.rows and 0 <= column < spec.columns
            if crossing or 0 <= row < spec.rows or 0 <= column < spec.columns:
                kind = NODE_TYPES[spec.control] if crossing else "priority"
                at = (_along(spec, column, spec.columns), _along(spec, row, spec.rows))
                plain.nodes.append(Node(_place(row, column), *at, kind))


def _street(spec: Grid, plain: PlainNetwork, stops: list[str], odd: bool) -> None:
    for a, b in pairwise(stops):
        if not spec.one_way or not odd:
            plain.edges.append(Edge(f"{a}_{b}", a, b, spec.lanes, spec.speed, MAIN))
        if not spec.one_way or odd:
            plain.edges.append(Edge(f"{b}_{a}", b, a, spec.lanes, spec.speed, MAIN))


def _along(spec: Grid, index: int, count: int) -> float:
    """Where the street `index` of `count` lies, or the end beyond the outermost ones [m]."""
    beyond = spec.spacing if spec.beyond is None else spec.beyond
    return -beyond if index < 0 else index * spec.spacing if index < count else (count - 1) * spec.spacing + beyond


def _place(row: int, column: int) -> str:
    return f"r{row + 1}c{column + 1}"
