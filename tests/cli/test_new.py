"""The command `new`: each package is tested as it stands, and found by name once installed."""

import os
import subprocess
import sys
from typing import get_args

import pytest

from baselines.new.command import Kind, package_files

KINDS = get_args(Kind)


def ran(*words, cwd, **more):
    """What a command printed; it must succeed."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))} | more
    done = subprocess.run(words, cwd=cwd, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("kind", KINDS)
def test_a_package_runs_as_it_stands_and_its_readme_s_command_once_it_is_installed(
    command, tmp_path, monkeypatch, kind
):
    monkeypatch.chdir(tmp_path)
    asked, folder = ("new", kind, "own_part", "--out=my part"), tmp_path / "my part"
    status, stdout, stderr = command(*asked)
    assert (status, stderr) == (0, "")
    assert stdout == (
        f"wrote my part: {', '.join(package_files(kind, 'own_part'))}\n"
        "test it: cd 'my part' && python -m pytest\n"
    )
    checked = sys.executable, "-m", "ruff", "check", "--isolated", "--line-length=100"
    ran(*checked, "--select=E,F,W,UP,N", ".", cwd=folder)
    assert "passed" in ran(
        sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", cwd=folder
    )
    status, _, stderr = command(*asked)
    assert (status, "exists already" in stderr) == (2, True), "nothing is overwritten"
    there = tmp_path / "installed"
    install = "-m", "pip", "install", "-q", "--no-build-isolation", "--no-deps"
    ran(sys.executable, *install, f"--target={there}", "./my part", cwd=tmp_path)
    (line,) = (
        each
        for each in (folder / "README.md").read_text().splitlines()
        if "swarm-forage evaluate" in each or " -c " in each
    )
    line = line.replace("swarm-forage ", f"{sys.executable} -m training.cli ", 1)
    line = line.replace("python -c", f"{sys.executable} -c").replace("--episodes 5", "--episodes 1")
    path = os.pathsep.join(filter(None, [str(there), *sys.path]))
    stdout = ran("sh", "-c", line, cwd=tmp_path, PYTHONPATH=path)
    assert ("own_part" in stdout) or ("swarm_forage_v2" in stdout)
