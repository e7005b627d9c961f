"""Run SUMO's netconvert as what it is: a program that crashes, hangs and opens files when it is fed badly.

It gets files that this program wrote, a fixed argument list, a folder of its own that is deleted afterwards, and limits
on time, memory and output. What it writes is stripped of its date, so that equal input gives equal bytes.
"""

import importlib.util
import re
import resource
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from drivegen.core.errors import MissingTool, UnusableInput
from drivegen.sumo.plain import PlainNetwork

TIMEOUT = 60.0
"""Longest run [s]; a network of scenario size takes 0.1 s, a city a few seconds."""

_MEMORY = 4 * 1024**3
_LARGEST_FILE = 1024**3
_FIXED = ("--no-turnarounds", "true", "--offset.disable-normalization", "true", "--output.street-names", "false")
_HEADER = re.compile(rb"<!--.*?-->\s*", re.DOTALL)
_MESSAGES = 10


class NetconvertRefused(UnusableInput):
    """netconvert did not make a network. `messages` are its own words, at most ten, for whoever repairs the input."""

    def __init__(self, sentence: str, messages: Sequence[str], reason: str = "netconvert") -> None:
        super().__init__(sentence, reason=reason)
        self.messages = tuple(messages[:_MESSAGES])


def plain_to_net(plain: PlainNetwork, precision: int = 2, timeout: float = TIMEOUT) -> bytes:
    """The SUMO network of `plain`, coordinates as given, with `precision` decimals; netconvert has `timeout` [s].

    Raises NetconvertRefused with netconvert's messages, or MissingTool where netconvert is not installed.
    """
    arguments = ["-n", "net.nod.xml", "-e", "net.edg.xml", "-x", "net.con.xml"]
    flags = ["--lefthand", str(plain.lefthand).lower(), "--precision", str(precision), "--xml-validation", "local"]
    return convert(plain.files(), [*arguments, *flags, *_FIXED, "-o", "out.net.xml"], "out.net.xml", timeout)


def convert(files: Mapping[str, bytes], arguments: Sequence[str], output: str, timeout: float = TIMEOUT) -> bytes:
    """Run netconvert on `files` (name to content) in a folder of its own and return the file `output` that it wrote.

    `arguments` name files by their bare names. The date header is cut off. Raises as `plain_to_net` does.
    """
    binary, home = _installed()
    with tempfile.TemporaryDirectory(prefix="drivegen-netconvert-") as name:
        folder = Path(name)
        for file, content in files.items():
            (folder / file).write_bytes(content)
        code, messages = _run([str(binary), *arguments], folder, home, timeout)
        result = folder / output
        if code != 0 or not result.is_file():
            raise _refusal(code, messages)
        return _HEADER.sub(b"", result.read_bytes(), count=1)


@cache
def _installed() -> tuple[Path, Path]:
    """Paths of the netconvert program and of SUMO_HOME."""
    spec = importlib.util.find_spec("sumo")
    home = Path(spec.origin).parent if spec is not None and spec.origin else None
    if home is None or not (home / "bin" / "netconvert").is_file():
        raise MissingTool("netconvert is not installed: pip install eclipse-sumo==1.28.0")
    return home / "bin" / "netconvert", home


def _run(command: list[str], folder: Path, home: Path, timeout: float) -> tuple[int, list[str]]:
    def limit() -> None:
        seconds = int(timeout) + 1
        for what, most in (
            (resource.RLIMIT_CPU, seconds),
            (resource.RLIMIT_AS, _MEMORY),
            (resource.RLIMIT_FSIZE, _LARGEST_FILE),
            (resource.RLIMIT_CORE, 0),
        ):
            hard_limit = resource.getrlimit(what)[1]  # nobody may raise what whoever started us has limited
            most = most if hard_limit == resource.RLIM_INFINITY else min(most, hard_limit)
            resource.setrlimit(what, (most, most))

    environment = {"SUMO_HOME": str(home), "PROJ_LIB": str(home / "data" / "proj"), "PATH": "/nonexistent"}
    environment |= {"LANG": "C.UTF-8", "HOME": str(folder)}
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, timeout=timeout, capture_output=True, check=False, preexec_fn=limit
        )
    except subprocess.TimeoutExpired:
        raise NetconvertRefused(f"netconvert was stopped after {timeout:.0f} s", [], reason="timeout") from None
    except OSError as error:
        raise MissingTool(f"netconvert cannot be started ({error.strerror}): reinstall eclipse-sumo==1.28.0") from error
    lines = (line.strip() for line in done.stderr.decode("utf-8", "replace").splitlines())
    return done.returncode, [line for line in lines if line and not line.startswith(("Warning", "Quitting"))]


def _refusal(code: int, messages: list[str]) -> NetconvertRefused:
    if code < 0 or code >= 128:
        return NetconvertRefused("netconvert crashed on this network", messages, reason="netconvert-crashed")
    errors = [message.removeprefix("Error: ") for message in messages if message.startswith("Error: ")]
    first = next(iter([*errors, *messages]), "it gives no reason")
    return NetconvertRefused(f"netconvert refuses this network: {first}", messages)
