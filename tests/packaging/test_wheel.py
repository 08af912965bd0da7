"""The wheel alone, in an environment outside the checkout, with dependencies from the index."""

import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.wheel

ROOT = Path(__file__).resolve().parents[2]
PIP = sys.executable, "-m", "pip"

LAYERS = "weighting", "motion", "both", "everything"

STEPS = f"""
from swarm_forage_env import parallel_env

for scenario in ("es1", "waypoints-05"):
    for learn in {LAYERS}:
        env = parallel_env(scenario, learn=learn)
        env.reset(seed=0)
        env.step({{agent: env.action_space(agent).sample() for agent in env.agents}})
        print(scenario, learn, len(env.agents))
"""

LEARNED = "from swarm_forage_env import parallel_env\nparallel_env(controller='learned-weighting')"
REMEDY = "needs 'safetensors': pip install 'swarm-forage[evaluate]'"

SHORT = "--set=duration=3", "--workers=1"
TINY = "--budget=1", "--every=1", "--worlds=1", "--held-back=1", *SHORT

COMMANDS = {
    "evaluate": [
        ("list", "es1"),
        ("list", "learned-both"),
        ("evaluate", "es1", "nc", "learned-both", "--episodes=1", "--plot=a.png", *SHORT),
        ("plot", "boxplot", "runs/es1", "--out=b.pdf"),
        ("reproduce", "ants2008", "--help"),
    ],
    "render": [("watch", "es1", "nc", "--video=a.mp4", "--frame=a.png", "--html=a.html", SHORT[0])],
    "train": [
        ("train", "weighting", "es1", "--population=4", *TINY),
        ("train", "motion", "es1", *TINY),
    ],
}
"""What each extra is for, on episodes of seconds."""


def run(*command, cwd, **variables):
    """Run a command that imports what is installed, and nothing else."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        command, cwd=cwd, env=kept | variables, capture_output=True, text=True, check=False,
        timeout=500,
    )  # fmt: skip


def run_well(*command, cwd, **variables):
    """What a command prints that must end well."""
    ended = run(*command, cwd=cwd, **variables)
    assert ended.returncode == 0, f"{command}\n{ended.stdout}{ended.stderr}"
    return ended.stdout


def new_environment(home):
    """The Python of a new environment."""
    run_well(sys.executable, "-m", "venv", "--without-pip", home, cwd=home)
    paths = {"base": str(home), "platbase": str(home)}
    return Path(sysconfig.get_path("scripts", "venv", paths)) / "python"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of this tree; no network: the build backend comes with the extra `dev`."""
    out = tmp_path_factory.mktemp("wheel")
    flags = "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir"
    run_well(*PIP, "wheel", *flags, out, ROOT, cwd=out)
    (path,) = out.glob("*.whl")
    return path


@pytest.fixture
def installed(wheel):
    """Install the wheel from the index into a new environment: its Python."""
    with tempfile.TemporaryDirectory() as home:

        def install(extra=""):
            python = new_environment(home)
            what = f"{wheel}[{extra}]" if extra else wheel
            pip = *PIP, "--python", python
            terms = "--quiet", "--no-compile", "--constraint", ROOT / "constraints.txt"
            run_well(*pip, "install", *terms, what, cwd=home)
            run_well(*pip, "check", cwd=home)
            return python

        yield install


def test_the_wheel_alone_brings_every_environment_and_says_which_extra_brings_more(
    installed, tmp_path
):
    python = installed()
    where = run_well(python, "-c", "import training; print(training.__file__)", cwd=tmp_path)
    assert Path(where.strip()).is_relative_to(python.parents[1])
    stepped = run_well(python, "-c", STEPS, cwd=tmp_path, XDG_CACHE_HOME=tmp_path).splitlines()
    sizes = {"es1": 10, "waypoints-05": 5}
    assert stepped == [f"{name} {each} {sizes[name]}" for name in sizes for each in LAYERS]
    refused = run(python, "-c", LEARNED, cwd=tmp_path)
    assert refused.stderr.splitlines()[-1].startswith("ModuleNotFoundError: policy ")
    assert refused.stderr.endswith(f"{REMEDY}\n")
    refused = run(python.with_name("swarm-forage"), "list", cwd=tmp_path)
    assert (refused.returncode != 0, refused.stdout) == (True, "")
    assert len(refused.stderr.splitlines()) == 1
    assert "swarm-forage[evaluate]" in refused.stderr


@pytest.mark.parametrize("extra", COMMANDS)
def test_an_extra_alone_brings_what_its_commands_need(installed, tmp_path, extra):
    command = installed(extra).with_name("swarm-forage")
    for arguments in COMMANDS[extra]:
        # Kernels as plain Python: every new environment would compile anew.
        run_well(command, *arguments, cwd=tmp_path, NUMBA_DISABLE_JIT="1")
