"""Python in processes of their own, which import this checkout."""

import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PIPES = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}


def start(*arguments, variables=None, **options):
    """Start Python, with these environment variables and options of `Popen`."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | (variables or {})
    command = sys.executable, *map(str, arguments)
    return subprocess.Popen(command, env=environment, text=True, **PIPES | options)


def run(*arguments, status=0, timeout=500, **options):
    """What Python writes to stdout and stderr until it ends, with this exit status."""
    process = start(*arguments, **options)
    stdout, stderr = process.communicate(timeout=timeout)
    assert process.returncode == status, stderr
    return stdout, stderr


def becomes_true(condition, seconds):
    """Wait for a condition; False if it does not come true in this time."""
    until = time.monotonic() + seconds
    while not (is_true := condition()) and time.monotonic() < until:
        time.sleep(0.1)
    return bool(is_true)
