"""A sequence whose items are made when asked for."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

T = TypeVar("T")


class Each(Sequence[T]):
    """`make(i)` for i from 0 to `count` - 1; none is kept."""

    def __init__(self, count: int, make: Callable[[int], T]) -> None:
        self._numbers, self._make = range(count), make

    def __len__(self) -> int:
        return len(self._numbers)

    def __getitem__(self, number: Any) -> Any:
        """The item of that number."""
        return self._make(self._numbers[number])
