"""How the viewer lays a recording out: the scene from above, beside it the image, plots, verdicts and a legend."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from drivegen.recording import colours


def from_above(centre: NDArray[np.floating], extent: float, name: str, contents: str | list[str]) -> rrb.Spatial3DView:
    """A view of `contents` that looks at `centre` (2,) from where about `extent` metres fit into it."""
    x, y = float(centre[0]), float(centre[1])
    eye = rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=(x, y - 0.42 * extent, 0.8 * extent),
        look_target=(x, y, 0.0),
        eye_up=(0.0, 0.0, 1.0),
    )
    return rrb.Spatial3DView(
        origin="/world",
        contents=contents,
        name=name,
        background=rrb.Background(color=colours.BACKGROUND, kind=rrb.BackgroundKind.SolidColor),
        line_grid=False,
        eye_controls=eye,
    )


def layout(centre: NDArray[np.floating], extent: float, *, image: bool, verdicts: bool) -> rrb.Blueprint:
    """A blueprint that looks at `centre` (2,) from where about `extent` metres fit into the view."""
    scene = from_above(centre, extent, "Scene", "$origin/**")
    side: list[rrb.View | rrb.Container] = []
    if image:
        side.append(rrb.Spatial2DView(origin="/bird_eye", name="The target's candidate goals, from above"))
    for kind, unit in (("speed", "m/s"), ("clearance", "m")):
        corner = rrb.PlotLegend(rrb.Corner2D.RightTop)
        side.append(rrb.TimeSeriesView(origin=f"/plots/{kind}", name=f"Target's {kind} [{unit}]", plot_legend=corner))
    if verdicts:
        columns = rrb.TextLogColumns(timeline_columns=["time"], text_log_columns=["loglevel", "body"])
        side.append(rrb.TextLogView(origin="/verdicts", name="Checker's verdicts", columns=columns))
    side.append(rrb.TextDocumentView(origin="/legend", name="Legend"))
    shares = [3.0] * image + [2.0, 2.0] + [2.0] * verdicts + [1.5]
    return playing(rrb.Horizontal(scene, rrb.Vertical(*side, row_shares=shares), column_shares=[5, 2]))


def playing(views: rrb.Container) -> rrb.Blueprint:
    """`views` alone, panels folded, time running again and again from the start."""
    parts = rr.blueprint.components
    return rrb.Blueprint(
        views,
        rrb.TimePanel(timeline="time", state="collapsed", play_state=parts.PlayState.Playing, loop_mode=parts.LoopMode.All),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
        auto_views=False,
    )
