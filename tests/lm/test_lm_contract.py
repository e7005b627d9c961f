"""What every backend keeps to: each file of the folder is tried the moment it exists."""

import pytest

from drivegen import plugins
from drivegen.errors import UnusableInput
from drivegen.lm.prompt import NoAnswer
from drivegen.lm.records import Mode
from tests.lm.asking import model, question, settings

BACKENDS = plugins.names("lm.backends")


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_backend_fails_with_a_type_where_nobody_answers(tmp_path, backend):
    name = "" if backend == "offline" else "m"
    nobody = {"base_url": "http://127.0.0.1:9", "retries": 0, "timeout": 1.0}
    asked = model(tmp_path, mode=Mode.OFF, backend=backend, model=name, output="prompted", **nobody)
    with pytest.raises(NoAnswer) as failure:
        asked.ask(question())
    assert failure.value.reason in ("no-model", "unreachable")


def test_a_model_that_cannot_be_asked_so_is_said_to_be_so(tmp_path):
    with pytest.raises(UnusableInput, match="prompted"):
        model(tmp_path, "http://127.0.0.1:9", mode=Mode.OFF, backend="anthropic", output="native").ask(question())


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_backend_says_what_a_picture_costs(backend):
    plugin = plugins.load("lm.backends", backend)
    assert 0 <= plugin.image_tokens(64, 64) <= plugin.image_tokens(768, 768)


def test_settings_that_make_no_sense_are_named():
    for wrong in ({"backend": "nobody"}, {"output": "loud"}, {"model": ""}, {"timeout": 0.0}, {"retries": -1}):
        with pytest.raises(UnusableInput, match="lm"):
            settings(**wrong)
