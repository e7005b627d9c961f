"""What every refusal of a file must be."""

from drivegen.core.errors import UnusableInput


def assert_one_sentence(refusal: UnusableInput, place: str) -> None:
    """It names the file, in one line, and has a reason of its own that rejected scenarios can be counted by."""
    assert place in str(refusal)
    assert "\n" not in str(refusal)
    assert refusal.reason != "unusable"
