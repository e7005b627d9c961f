"""`drivegen weights`: trained models as one file, to carry them to another machine."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option, Typer

from drivegen.cli._console import plain
from drivegen.cli._files import BUNDLE, expect_own, lies_in
from drivegen.cli._project import MODELS
from drivegen.core.errors import UnusableInput
from drivegen.store.bundle import ALLOWED, pack, unpack

command = Typer(no_args_is_help=True, rich_markup_mode=None)

Bundle = Annotated[Path, Argument(metavar="FILE", help="The file that carries the models.")]
Models = Annotated[Path, Option(help="The folder of trained models.")]


@command.callback()
def about() -> None:
    """Carry trained models to another machine: weights depend on the processor in their last bits."""


@command.command()
def save(bundle: Bundle, models: Models = MODELS) -> None:
    """Pack the trained models into FILE."""
    if lies_in(bundle, models):
        raise UnusableInput(f"{bundle} would lie among the models that are packed: name a place outside {models}")
    expect_own(bundle, BUNDLE)
    if models != MODELS:
        _expect_models(models)
    plain().print(f"{bundle}: {len(pack(models, bundle))} files of {models}")


def _expect_models(folder: Path) -> None:
    """Raises UnusableInput where a folder that was named is another one than that of models: nothing of it is to be removed."""
    files = [file for file in sorted(folder.rglob("*")) if file.is_file()]
    others = [str(file) for file in files if file.suffix not in ALLOWED]
    if others or not files:
        what = f"something else, {others[0]}" if others else "nothing"
        raise UnusableInput(f"{folder} is not the folder of trained models, it holds {what}: name the one that is, as {MODELS}")


@command.command()
def load(bundle: Bundle, models: Models = MODELS) -> None:
    """Put the models of FILE where the pipeline looks for them; exits 2 where models lie there already.

    With the dvc.lock that belongs to them, as git has it, `make run` takes them and trains nothing.
    """
    if models.is_dir() and any(models.iterdir()):
        raise UnusableInput(f"{models} holds models already: move that folder away first, nothing is replaced")
    plain().print(f"{models}: {len(unpack(bundle, models))} files of {bundle}")
