"""The forms of English nouns and verbs, as the lexicon lists them."""

_DOUBLED = {
    "cut",
    "slam",
    "stop",
    "nip",
    "slip",
    "slot",
    "swap",
    "jam",
    "get",
    "run",
    "sit",
    "hit",
    "hop",
    "bar",
    "step",
    "hug",
    "dog",
}
_IRREGULAR = {
    "overtake": ("overtook", "overtaken"), "undertake": ("undertook", "undertaken"), "take": ("took", "taken"),
    "do": ("done", "did"),
    "cut": ("cut",), "come": ("came",), "drive": ("drove", "driven"), "go": ("gone", "went"), "stand": ("stood",),
    "hit": ("hit",),
    "make": ("made",), "get": ("got",), "lead": ("led",), "swing": ("swung",), "begin": ("beginning",), "lose": ("lost",),
    "slide": ("slid",),
}  # fmt: skip


def nouns(name: str) -> tuple[str, str]:
    """Singular and plural."""
    if name.endswith(("s", "ch", "sh", "x")):
        return name, f"{name}es"
    if name.endswith("y") and name[-2] not in "aeiou":
        return name, f"{name[:-1]}ies"
    return name, f"{name}s"


def verbs(phrase: str) -> list[str]:
    """All forms of the first word, with the words that follow it."""
    verb, _, rest = phrase.partition(" ")
    stem = verb[:-1] if verb.endswith("e") and not verb.endswith("ee") else verb + verb[-1] if verb in _DOUBLED else verb
    third = f"{verb}es" if verb in ("go", "do") else nouns(verb)[1]
    past = f"{verb[:-1]}ied" if verb.endswith("y") and verb[-2] not in "aeiou" else f"{stem}ed"
    forms = [verb, third, f"{stem}ing", past, *_IRREGULAR.get(verb, ())]
    return [f"{form} {rest}".strip() for form in forms]
