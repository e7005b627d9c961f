"""The report: the paper's tables with ours beside theirs, in one HTML page that works offline, and as Markdown."""

from drivegen.report.evidence import Curve, Evidence, Link, Picture
from drivegen.report.page import build_page
from drivegen.report.sections import all_sections

__all__ = ["Curve", "Evidence", "Link", "Picture", "all_sections", "build_page"]
