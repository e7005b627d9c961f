"""The networks that a corpus is simulated on: real ones, from SUMO's package and from a folder, and layouts of our own."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from typing import Any

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.core.scenario import SPLITS
from drivegen.layouts.compile import compile_map
from drivegen.layouts.spec import MapSpec

REAL, OWN = KINDS = ("real", "own")


@dataclass(frozen=True)
class Networks:
    """By split and name: `real` networks as paths below SUMO_HOME, real ones `outside` it as paths below a folder that a user
    has, and our `own` as map specifications."""

    real: dict[str, dict[str, str]]
    outside: dict[str, dict[str, str]]
    own: dict[str, dict[str, Any]]

    def check(self, scenarios: Iterable[str], density: Iterable[str]) -> None:
        """Raise UnusableInput unless no network is in two splits, every split is one, and both kinds have a density."""
        if set(density) != set(KINDS):
            raise UnusableInput("corpus.density needs a range for `real` and one for `own`, and nothing else")
        for splits in (scenarios, self.real, self.outside, self.own):
            if unknown := set(splits) - set(SPLITS):
                raise UnusableInput(f"corpus: there is no split {unknown.pop()!r}; there are {', '.join(SPLITS)}")
        split_of: dict[str, str] = {}
        for split in SPLITS:
            for name, source in chain.from_iterable(group.get(split, {}).items() for group in vars(self).values()):
                for word in (name, str(source)):
                    if split_of.setdefault(word, split) != split or not name.replace("_", "").isalnum():
                        raise UnusableInput(
                            f"corpus: network {name!r} is in {split_of[word]} and {split}, or its name is no plain word"
                        )

    def chosen(self, names: Iterable[str]) -> "Networks":
        """Only those of these names, all of them where none is named. Raises UnusableInput for a name that no network has."""
        chosen = set(names)
        there = {name for group in vars(self).values() for named in group.values() for name in named}
        if unknown := chosen - there:
            raise UnusableInput(f"corpus.only names {min(unknown)!r}, which is no network of corpus.networks")
        groups = {
            kind: {split: {name: source for name, source in named.items() if name in chosen} for split, named in group.items()}
            for kind, group in vars(self).items()
        }
        return Networks(**groups) if chosen else self

    def located(self, folder: str) -> "tuple[Networks, list[str]]":
        """The networks with those of `folder` ("": none) among the real ones, and the names of those that are not there."""
        files = {
            split: {name: Path(folder, path).resolve() for name, path in paths.items()} for split, paths in self.outside.items()
        }
        there = {split: {n: str(f) for n, f in named.items() if folder and f.is_file()} for split, named in files.items()}
        real = {split: {**self.real.get(split, {}), **there.get(split, {})} for split in SPLITS}
        missing = [name for split, named in files.items() for name in named if name not in there[split]]
        return replace(self, real=real, outside={}), missing

    def shares(self, split: str, total: int, own_share: float) -> Iterator[tuple[str, str, int]]:
        """Name, kind and number of scenarios of each network of a split that gets any of its `total`."""
        real, own = self.real.get(split, {}), self.own.get(split, {})
        of_own = 0 if not own else total if not real else round(total * own_share)
        for names, kind, count in ((real, REAL, total - of_own), (own, OWN, of_own)):
            for i, name in enumerate(names):
                if share := count * (i + 1) // len(names) - count * i // len(names):
                    yield name, kind, share

    def read(self, split: str, name: str) -> bytes:
        """The SUMO network. Raises UnusableInput for an unsound specification, MissingTool where SUMO or its file is missing."""
        if name not in self.real.get(split, {}):
            try:
                return compile_map(MapSpec.model_validate({"road": self.own[split][name]}))
            except ValueError as error:  # pydantic's
                raise UnusableInput(f"corpus: the map {name!r} is no sound specification: {error}") from None
        sumo = find_spec("sumo")
        if sumo is None or sumo.origin is None:
            raise MissingTool("the corpus takes its networks from eclipse-sumo: pip install eclipse-sumo==1.28.0")
        file = Path(sumo.origin).parent / self.real[split][name]
        if not file.exists():
            raise MissingTool(f"{file} is not there: network {name!r} of the corpus is not part of this SUMO")
        return file.read_bytes()
