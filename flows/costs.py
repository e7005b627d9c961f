"""What stages took, in files beside what they wrote. DVC knows nothing of these, so whoever brings outputs back minds them."""

from collections.abc import Collection
from pathlib import Path

COSTS = Path(".drivegen/costs")


def forget_costs(stages: Collection[str], root: Path) -> None:
    """Remove what `stages` of the workspace `root` took: what they have written is another run's now, or gone."""
    for file in (root / COSTS).glob("*.parquet"):
        if any(is_of(file.stem, stage) for stage in stages):
            file.unlink()


def is_of(cost: str, stage: str) -> bool:
    """Whether costs `<stage>-<item>`, or `<stage>-<item>-<part>`, are of dvc.lock's `<stage>@<item>`, or of one without items.

    Stages of another dvc.yaml have its path before their name: `stages/dvc.yaml:rank`.
    """
    name = stage.rpartition(":")[2].replace("@", "-", 1)
    return cost == name or cost.startswith(f"{name}-")
