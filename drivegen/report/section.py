"""A section of the report: words, tables, figures and links."""

from dataclasses import dataclass

from drivegen.report.evidence import Link, Picture
from drivegen.report.table import Table


@dataclass(frozen=True)
class Figure:
    """A picture with its words; `media` is its MIME type, two fit beside one another if it is `wide`, else three.

    `recording` is the relative path of a recording of what it shows, "" if there is none.
    """

    title: str
    caption: str
    media: str
    data: bytes
    wide: bool
    recording: str = ""

    @classmethod
    def svg(cls, title: str, caption: str, data: bytes) -> "Figure":
        """A plot."""
        return cls(title, caption, "image/svg+xml", data, wide=True)

    @classmethod
    def png(cls, picture: Picture, *, wide: bool) -> "Figure":
        """A picture."""
        return cls(picture.title, picture.caption, "image/png", picture.png, wide, picture.recording)


@dataclass(frozen=True)
class Section:
    """`lead` is one paragraph; `missing` says what to run where nothing was measured."""

    anchor: str
    title: str
    lead: str
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
    links: tuple[Link, ...] = ()
    missing: str = ""


def not_measured(stage: str) -> str:
    """The sentence for a part that has not run."""
    return f"Not measured: the stage {stage} has not run."
