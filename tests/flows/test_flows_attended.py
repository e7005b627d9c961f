"""Whatever ends a flow ends what it has started: tried with flows of a few lines, each in a process of its own."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from flows import attended

ROOT = Path(__file__).parents[2]

FLOW = """
import signal, sys, threading, time
from flows import attended

def stop(*_):
    time.sleep(2)  # as slow as who writes down first that it was stopped
    sys.exit(3)

signal.signal(signal.SIGHUP, signal.SIG_DFL)  # whoever runs the tests under nohup lets all ignore it
signal.signal(signal.SIGTERM, stop)
server = attended.start(["sleep", "60"])
with attended.stopping_work():
    def stage():
        with attended.work(["sh", "-c", "sleep 61; true"]) as process:
            process.wait()
            print("stage ended", flush=True)
        try:
            with attended.work(["sleep", "62"]):
                print("another stage began", flush=True)
        except InterruptedError:
            print("no other stage began", flush=True)
    threading.Thread(target=stage).start()
    time.sleep(60)
"""


def sleepers(flow: psutil.Process) -> list[psutil.Process]:
    return [child for child in flow.children(recursive=True) if child.name() == "sleep"]


def until(condition, seconds: float = 20.0) -> bool:
    deadline = time.monotonic() + seconds
    while not (met := condition()) and time.monotonic() < deadline:
        time.sleep(0.05)
    return bool(met)


@pytest.fixture
def flow():
    with subprocess.Popen([sys.executable, "-c", FLOW], cwd=ROOT, text=True, stdout=subprocess.PIPE) as process:
        assert until(lambda: len(sleepers(psutil.Process(process.pid))) == 2)
        yield process
        process.kill()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGHUP])
def test_a_flow_that_is_killed_leaves_neither_server_nor_stage(flow, number):
    left = psutil.Process(flow.pid).children(recursive=True)
    assert len(left) == 5  # two attendants, a server, a shell and its stage
    flow.send_signal(number)
    assert flow.wait(5) == -number
    assert until(lambda: not any(process.is_running() and process.status() != "zombie" for process in left))


def test_a_stage_ends_with_the_signal_and_the_server_with_the_flow(flow):
    (server,) = (child for child in sleepers(psutil.Process(flow.pid)) if child.cmdline()[-1] == "60")
    flow.send_signal(signal.SIGTERM)
    assert flow.stdout.readline() == "stage ended\n"
    assert flow.stdout.readline() == "no other stage began\n"
    assert server.is_running()
    assert flow.wait(10) == 3
    assert until(lambda: not server.is_running() or server.status() == "zombie")


@pytest.mark.parametrize(("command", "code"), [("exit 0", 0), ("exit 7", 7), ("kill -9 $$", 137), ("cat", 0)])
def test_what_is_attended_ends_with_its_own_exit_code(command, code):
    with attended.start(["sh", "-c", command]) as process:
        assert process.wait(10) == code


def test_what_a_stage_that_was_killed_leaves_behind_ends_with_it():
    with attended.start(["sh", "-c", "sleep 60 & echo $!; kill -9 $$"], stdout=subprocess.PIPE, text=True) as process:
        left = psutil.Process(int(process.stdout.readline()))
        assert process.wait(10) == 137
    assert until(lambda: not left.is_running() or left.status() == "zombie")


def test_a_program_that_is_not_there_is_named():
    with attended.start(["no-such-program"], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr.read() == "no-such-program: No such file or directory\n"
        assert process.wait(10) == 127
