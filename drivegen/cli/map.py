"""`drivegen map`: a road network from words."""

from pathlib import Path
from typing import Annotated

from rich.console import Console
from typer import Argument, Option

from drivegen.maps.build import ACCOUNT, NETWORK, PICTURE, build_map


def command(
    text: Annotated[str, Argument(help='The road in words, e.g. "four-way crossing with signals, two lanes each way, 50 km/h".')],
    out: Annotated[Path, Option(help="Folder for map.net.xml (SUMO), map.json (understood, ignored) and map.png.")],
    seed: Annotated[int, Option(help="What the words leave open is drawn from it.")] = 7,
) -> None:
    """Write the road network that TEXT describes; exits 2, saying what it can do, where the text is not understood."""
    account = build_map(text, seed, folder=out).account
    console = Console(soft_wrap=True, highlight=False, markup=False)
    for told in account["understood"]:
        console.print(f"understood  {told['phrase']}: {told['meaning']}")
    for word in ("assumed", "ignored", "failed"):
        if account[word]:
            console.print(f"{word:10}  {'; '.join(map(str, account[word]))}")
    console.print(f"written     {', '.join(str(out / name) for name in (NETWORK, ACCOUNT, PICTURE))}")
