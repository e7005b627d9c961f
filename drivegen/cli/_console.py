"""Where commands print their lines."""

from rich.console import Console


def plain(stderr: bool = False) -> Console:
    """Prints lines as they are: paths and brackets are neither wrapped nor read as markup."""
    return Console(stderr=stderr, soft_wrap=True, highlight=False, markup=False)
