"""Generated traffic as it is: the scenes that the others attack, before anybody has touched them."""

from drivegen.adversaries.base import About
from drivegen.adversaries.shared.unchanged import Unchanged

ABOUT = About(title="generated, as it is", traffic="generated", varies="nothing", source="none")


class Plugin(Unchanged):
    """See the module."""
