"""Logged traffic as it is: what the driver meets without anybody's intention."""

from drivegen.adversaries.base import About
from drivegen.adversaries.shared.unchanged import Unchanged

ABOUT = About(title="logs", traffic="log", varies="nothing", source="none")


class Plugin(Unchanged):
    """See the module."""
