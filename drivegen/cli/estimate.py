"""`drivegen estimate`: what a language model would cost, before a run."""

from rich.console import Console

from drivegen.cli._lm import MaxUsd, Words, model, role
from drivegen.lm.prices import estimate
from drivegen.maps.writers.language_model import prompt
from drivegen.settings import read_section

_MAP_TOKENS = 500
"""Of an answer with a map of ordinary size."""


def command(lm: Words = None, max_usd: MaxUsd = None) -> None:
    """Print calls, tokens and dollars of the descriptions in params.yaml (maps.prompts); nobody is asked."""
    settings, asking = role("maps", lm, max_usd), model("maps", lm, max_usd)
    console = Console(soft_wrap=True, highlight=False, markup=False)
    if not settings.model:
        console.print("no language model is configured for maps: nobody is asked, nothing is spent (try --lm)")
        return
    texts = read_section("maps.prompts").values()
    found = estimate(settings, [asking.request(prompt(text)) for text in texts], _MAP_TOKENS)
    console.print(f"model       {asking.description}")
    console.print(f"calls       {found.calls}")
    console.print(f"tokens      about {found.input_tokens} in, {found.output_tokens} out")
    console.print(f"dollars     {_dollars(found.usd)}; at most {_dollars(found.most_usd)}; a run stops at {settings.max_usd:.4f}")


def _dollars(usd: float | None) -> str:
    return "unknown" if usd is None else f"{usd:.4f}"
