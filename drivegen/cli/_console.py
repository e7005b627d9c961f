"""Where commands print their lines."""

from rich.console import Console

TABLE = 240
"""Characters that a line of a table of cases or drivers may have, whatever the terminal: names must not be cut."""


def plain(stderr: bool = False, least: int = 0) -> Console:
    """Prints lines as they are: paths and brackets are neither wrapped nor read as markup; tables have `least` characters."""
    console = Console(stderr=stderr, soft_wrap=True, highlight=False, markup=False)
    console.width = max(console.width, least)
    return console
