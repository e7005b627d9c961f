"""How sentences say numbers of things."""


def many(count: int, noun: str) -> str:
    """A number of things in words, also of one: "1 run", "2 runs"."""
    return f"{count} {noun}{'s' * (count != 1)}"
