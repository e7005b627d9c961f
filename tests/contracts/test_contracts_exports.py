"""What `from drivegen import ...` offers is listed, sorted and complete."""

import inspect

import drivegen


def test_exported_names_are_sorted_and_exact():
    public = {name for name, value in vars(drivegen).items() if not name.startswith("_") and inspect.isclass(value)}
    assert drivegen.__all__ == sorted(public)
