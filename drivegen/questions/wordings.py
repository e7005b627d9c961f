"""The wordings of the question where vehicles will be, by the version that `lm.goals.prompt` names."""

from drivegen.core.errors import UnusableInput
from drivegen.questions import goals_1, goals_2
from drivegen.questions.goals import Wording

LIKELIEST = {wording.version: wording for wording in (goals_1.LIKELIEST, goals_2.LIKELIEST)}


def likeliest(version: str) -> Wording:
    """That of a version. Raises UnusableInput, which names those that there are."""
    if version not in LIKELIEST:
        raise UnusableInput(f"lm.goals.prompt is one of {', '.join(LIKELIEST)}, not {version!r}")
    return LIKELIEST[version]
