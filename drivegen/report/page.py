"""The page: sections through a Jinja template into one HTML file with everything inside it."""

import base64
from collections.abc import Sequence
from importlib.resources import files

from jinja2 import Environment, StrictUndefined

from drivegen.report.section import Figure, Section


def build_page(sections: Sequence[Section], source: str) -> str:
    """HTML that loads nothing from anywhere; the same text for the same sections. `source` is the data set in words."""
    here = files("drivegen.report")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["inline"] = _inline
    template = environment.from_string(here.joinpath("page.html.j2").read_text())
    return template.render(sections=sections, source=source, style=here.joinpath("page.css").read_text())


def _inline(figure: Figure) -> str:
    return f"data:{figure.media};base64,{base64.b64encode(figure.data).decode()}"
