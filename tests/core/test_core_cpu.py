"""Processor time is that of this process and of its children once they have ended."""

import subprocess
import sys
import time

from drivegen.core.cpu import cpu_seconds


def test_an_ended_child_counts_and_waiting_does_not():
    began = cpu_seconds()
    subprocess.run([sys.executable, "-c", "import time\nwhile time.process_time() < 0.2: pass"], check=True)
    ended = cpu_seconds()
    time.sleep(0.2)
    assert ended - began >= 0.15
    assert cpu_seconds() - ended < 0.1
