"""The folder of a round of corner cases; its name is the round's number, the round before lies beside it.

Shard by shard it holds `samples` and `driven` (the target alone, as it was driven), further `knowledge.json`, pooled over all
rounds so far, and `collisions`: pictures (PNG) with words (TXT) and their places (JSON).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import orjson

from drivegen.core.errors import MissingTool
from drivegen.core.scenario import Trajectories
from drivegen.corner_cases.collisions import Collision, in_words, picture, telling
from drivegen.corner_cases.knowledge import Knowledge
from drivegen.corner_cases.rounds import Drive
from drivegen.lm.prompt import Image
from drivegen.questions.goals import examples
from drivegen.store.collisions import FOLDER, Where, write_pictured
from drivegen.store.files import write_json
from drivegen.store.lookup import DRIVEN, SAMPLES, samples_in, scenario_in
from drivegen.store.samples import read_samples, write_samples


@dataclass(frozen=True)
class RoundFolder:
    """Reads and writes the folder `path` of one round."""

    path: Path

    @property
    def number(self) -> int:
        """Of the round, from 0."""
        return int(self.path.name)

    @property
    def before(self) -> "RoundFolder":
        """The folder of the round before."""
        return RoundFolder(self.path.parent / str(self.number - 1))

    @property
    def collisions(self) -> Path:
        """Where pictures and words are."""
        return self.path / FOLDER

    def shown(self) -> tuple[str | Image, ...]:
        """Pictures and words of collisions, as worked examples; nothing where nothing collided."""
        return examples(str(self.collisions)) if self.collisions.is_dir() else ()

    @property
    def _knowledge(self) -> Path:
        return self.path / "knowledge.json"

    def knowledge_before(self, strength: float) -> Knowledge:
        """What the rounds before have taught; none with the prior's `strength` in round 0.

        Raises MissingTool where the round before was not played.
        """
        if self.number == 0:
            return Knowledge.none(strength)
        return Knowledge.from_json(orjson.loads(self.before._expect(self.before._knowledge).read_bytes()))

    def write_knowledge(self, knowledge: Knowledge) -> None:
        """That of all rounds up to this one."""
        write_json(self._knowledge, knowledge.to_json())

    def write_drives(self, shard: str, drives: Sequence[Drive]) -> None:
        """Samples and driven targets of the scenarios of one shard; `shard` is its file's name."""
        write_samples(self.path / SAMPLES / shard, [drive.samples for drive in drives])
        write_samples(self.path / DRIVEN / shard, [drive.driven for drive in drives])

    def driven(self, shard: str) -> list[Trajectories]:
        """The target's motion (K, T) in each scenario of a shard; raises MissingTool where the round was not played."""
        return [driven.motion[:, 0] for driven in read_samples(self._expect(self.path / DRIVEN / shard))]

    def write_pictures(self, collisions: Sequence[tuple[Path, Collision]], knowledge: Knowledge, most: int) -> None:
        """At most `most` of the round's `collisions`, the most telling ones; each comes with the shard of its scenario."""
        shards = {collision.scenario_id: shard for shard, collision in collisions}
        for number, one in enumerate(telling([collision for _, collision in collisions], knowledge, most)):
            shard = shards[one.scenario_id]
            scenario = scenario_in(shard, one.scenario_id)
            traffic, driven = (samples_in(self.path / part / shard.name, one.scenario_id) for part in (SAMPLES, DRIVEN))
            png = picture(one, scenario, traffic, driven.motion[:, 0])
            where = Where(one.scenario_id, shard.name, one.sample, one.partner, one.step)
            write_pictured(self.collisions / str(number), png, in_words(one, knowledge), where)

    def _expect(self, path: Path) -> Path:
        """`path`, which this round writes; raises MissingTool where it is not there."""
        if not path.exists():
            raise MissingTool(f"{path} is not there: run the round before: corner@{self.number}")
        return path
