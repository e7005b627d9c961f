"""From a reply's text to a validated answer, or to words that tell the model what to mend."""

from pydantic import ValidationError

from drivegen.lm.prompt import A, Prompt

_FENCE = "```"
_MOST_LINES = 10
_LONGEST_LINE = 200
_LONGEST_REPLY = 1_000_000
"""Characters: a hundred times the longest answer that anything asks for."""


class InvalidReply(ValueError):
    """The reply is not an answer; the message is what the model is told."""


def read(text: str, prompt: Prompt[A]) -> A:
    """The answer in `text`, bare JSON or JSON in a code fence. Raises InvalidReply."""
    if len(text) > _LONGEST_REPLY:
        raise InvalidReply(f"the reply has {len(text)} characters: answer in fewer")
    try:
        answer = prompt.answer.model_validate_json(_unfenced(text))
    except ValidationError as error:
        raise InvalidReply(_complaint(error)) from None
    if prompt.check is not None:
        try:
            prompt.check(answer)
        except ValueError as error:
            raise InvalidReply(_short(str(error).splitlines())) from None
    return answer


def _unfenced(text: str) -> str:
    """What stands in a code fence that is all of the text, with or without the name of a language; else the text."""
    name, line_end, inner = text.strip().removeprefix(_FENCE).partition("\n")
    fenced = text.lstrip().startswith(_FENCE) and inner.endswith(_FENCE) and bool(line_end)
    return inner.removesuffix(_FENCE) if fenced and (not name.strip() or name.strip().isalpha()) else text


def _complaint(error: ValidationError) -> str:
    lines = []
    for detail in error.errors(include_url=False, include_context=False, include_input=False):
        place = ".".join(str(part) for part in detail["loc"])
        lines.append(f"{place}: {detail['msg']}" if place else detail["msg"])
    return _short(lines)


def _short(lines: list[str]) -> str:
    problems = [line[:_LONGEST_LINE] for line in lines[:_MOST_LINES]]
    more = len(lines) - len(problems)
    return "\n".join([*problems, f"(and {more} more)"] if more else problems)
