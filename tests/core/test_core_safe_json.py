"""JSON from outside is counted before it is read."""

import pytest

from drivegen.core import safe_json
from drivegen.core.errors import UnusableInput


def test_json_is_read_and_what_is_none_is_named():
    assert safe_json.parse(b'{"a": [1, 2.5, null]}', "map.json") == {"a": [1, 2.5, None]}
    with pytest.raises(UnusableInput, match=r"^map\.json is not JSON: ") as refusal:
        safe_json.parse(b'{"a": [', "map.json", "bad-map")
    assert refusal.value.reason == "bad-map"


@pytest.mark.parametrize(
    "raw", [b"[" + b"0," * 50 + b"0]", b"[" + b"{}," * 30 + b"{}]", b"[" * 51 + b"]" * 51, b"[" + b" " * 990 + b"]"]
)
def test_many_values_or_bytes_are_refused_before_they_are_read(monkeypatch, raw):
    monkeypatch.setattr(safe_json, "MAX_VALUES", 50)
    monkeypatch.setattr(safe_json, "MAX_BYTES", 990)
    monkeypatch.setattr(safe_json.orjson, "loads", None)  # nobody gets as far as parsing
    with pytest.raises(UnusableInput, match=r"^map\.json has more than") as refusal:
        safe_json.parse(raw, "map.json")
    assert refusal.value.reason == "too-large"


def test_what_is_nested_without_end_is_no_json():
    with pytest.raises(UnusableInput, match=r"^map\.json is not JSON"):
        safe_json.parse(b"[" * 100_000, "map.json")
