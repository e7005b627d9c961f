"""The page: sections through a Jinja template into one HTML file with everything inside it."""

import base64
from importlib.resources import files

from jinja2 import Environment, StrictUndefined

from drivegen.report.evidence import Evidence
from drivegen.report.section import Figure
from drivegen.report.sections import all_sections


def build_page(evidence: Evidence) -> str:
    """HTML that loads nothing from anywhere; the same text for the same evidence."""
    here = files("drivegen.report")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["inline"] = _inline
    template = environment.from_string(here.joinpath("page.html.j2").read_text())
    return template.render(sections=all_sections(evidence), source=evidence.source, style=here.joinpath("page.css").read_text())


def _inline(figure: Figure) -> str:
    return f"data:{figure.media};base64,{base64.b64encode(figure.data).decode()}"
