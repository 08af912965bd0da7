"""What a user installs: the wheel, alone in an environment, outside the checkout.

Without the network the dependencies are those of the running environment, and extras are hidden.
The tests marked `wheel` have pip find and install them from the package index.
"""

import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

import pytest

from swarm_forage_env.extras import EXTRAS

ROOT = Path(__file__).resolve().parents[2]
PIP = sys.executable, "-m", "pip"

HIDING = """
import sys

class Without:
    def __init__(self, finder):
        self._finder = finder

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {hidden}:
            return None
        return self._finder.find_spec(name, path, target)

    def __getattr__(self, name):
        return getattr(self._finder, name)

sys.meta_path[:] = map(Without, sys.meta_path)
sys.argv = ["swarm-forage", *{arguments}]
"""

COMMAND = "from training.cli import main\nmain()"

STEPS = """
from swarm_forage_env import parallel_env

for scenario, *learn in {made}:
    env = parallel_env(scenario, **dict(zip(["learn"], learn)))
    env.reset(seed=0)
    env.step({{agent: env.action_space(agent).sample() for agent in env.agents}})
    print(scenario, *learn, len(env.agents))
"""

MADE = [
    *(("es1", learn) for learn in ("weighting", "motion", "both", "everything")),
    ("waypoints-05",),
]
STEPPED = "es1 weighting 10\nes1 motion 10\nes1 both 10\nes1 everything 10\nwaypoints-05 5\n"

LEARNED = "from swarm_forage_env import parallel_env\nparallel_env(controller='learned-weighting')"
REMEDY = "needs 'safetensors': pip install 'swarm-forage[train]'"

SHORT = "--set=duration=3", "--workers=1"
TINY = "--budget=1", "--every=1", "--worlds=1", "--held-back=1", *SHORT

COMMANDS = {
    "evaluate": [
        ("list", "es1"),
        ("list", "learned-both"),
        ("evaluate", "es1", "nc", "--episodes=1", "--plot=a.png", *SHORT),
        ("plot", "boxplot", "runs/es1", "--out=b.pdf"),
        ("reproduce", "ants2008", "--help"),
    ],
    "render": [("watch", "es1", "nc", "--video=a.mp4", "--frame=a.png", "--html=a.html", SHORT[0])],
    "train": [
        ("train", "weighting", "es1", "--population=4", *TINY),
        ("train", "motion", "es1", *TINY),
        ("evaluate", "es1", "learned-both", "--episodes=1", *SHORT),
    ],
}
"""What each extra is for, on episodes of seconds."""


def run(*command, cwd, **variables):
    """Run a command that imports what is installed, and nothing else."""
    ours = "PYTHONPATH", "SWARM_CHECK_SHAPES"
    kept = {name: value for name, value in os.environ.items() if name not in ours}
    return subprocess.run(
        command, cwd=cwd, env=kept | variables, capture_output=True, text=True, check=False,
        timeout=500,
    )  # fmt: skip


def run_well(*command, cwd, **variables):
    """What a command prints that must end well."""
    ended = run(*command, cwd=cwd, **variables)
    assert ended.returncode == 0, f"{command}\n{ended.stdout}{ended.stderr}"
    return ended.stdout


def run_plain(*command, cwd):
    """The same with kernels as plain Python: every new environment compiles anew."""
    return run_well(*command, cwd=cwd, NUMBA_DISABLE_JIT="1")


def without(extras, code, *arguments):
    """Lines of Python that run where extras are missing, under a command's arguments."""
    hidden = sorted(set().union(*(EXTRAS[extra] for extra in extras)))
    return HIDING.format(hidden=hidden, arguments=arguments) + code


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


@pytest.fixture(scope="module")
def environment(wheel, tmp_path_factory):
    """A new environment with the wheel; the dependencies are those of the running one."""
    home = tmp_path_factory.mktemp("environment")
    python = new_environment(home)
    paths = {"base": str(home), "platbase": str(home)}
    packages = Path(sysconfig.get_path("purelib", "venv", paths))
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    flags = "--no-deps", "--no-index", "--quiet"
    run_well(*PIP, "--python", python, "install", *flags, wheel, cwd=home)
    return python


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


def test_the_installed_world_is_the_wheels(environment, tmp_path):
    code = "import swarm_forage_env as s; print(s.__file__)"
    where = Path(run_well(environment, "-c", code, cwd=tmp_path).strip())
    assert where.is_relative_to(environment.parents[1])


def test_the_installed_command_lists_scenarios_and_controllers(environment, tmp_path):
    listed = run_well(environment.with_name("swarm-forage"), "list", cwd=tmp_path)
    assert {"es1", "ssgikf"} <= set(listed.split())


def test_world_and_controllers_need_no_extra(environment, tmp_path):
    code = without(EXTRAS, "import baselines.controllers" + STEPS.format(made=MADE))
    assert run_plain(environment, "-c", code, cwd=tmp_path) == STEPPED


def test_the_commands_need_the_extra_evaluate_only(environment, tmp_path):
    for arguments in COMMANDS["evaluate"]:
        code = without(EXTRAS.keys() - {"evaluate"}, COMMAND, *arguments)
        run_plain(environment, "-c", code, cwd=tmp_path)


def test_a_learned_controller_without_its_extra_says_in_one_line_which(environment, tmp_path):
    refused = run(environment, "-c", without(["train"], LEARNED), cwd=tmp_path)
    assert refused.stderr.splitlines()[-1].startswith("ModuleNotFoundError: policy ")
    assert refused.stderr.endswith(f"{REMEDY}\n")
    arguments = "evaluate", "es1", "nc", "learned-weighting", *SHORT
    refused = run(environment, "-c", without(["train"], COMMAND, *arguments), cwd=tmp_path)
    assert (refused.returncode, refused.stdout) == (1, "")
    assert refused.stderr == f"swarm-forage: this command {REMEDY}\n", "before anything ran"


def test_a_command_without_its_extra_says_in_one_line_which(environment, tmp_path):
    refused = run(environment, "-c", without(EXTRAS, COMMAND, "list"), cwd=tmp_path)
    assert (refused.returncode != 0, refused.stdout) == (True, "")
    assert len(refused.stderr.splitlines()) == 1
    assert "swarm-forage[evaluate]" in refused.stderr


@pytest.mark.wheel
def test_the_wheel_alone_brings_every_environment(installed, tmp_path):
    python = installed()
    cache = str(tmp_path / "cache")
    code = STEPS.format(made=MADE)
    assert run_well(python, "-c", code, cwd=tmp_path, XDG_CACHE_HOME=cache) == STEPPED
    refused = run(python, "-c", LEARNED, cwd=tmp_path)
    assert refused.stderr.endswith(f"{REMEDY}\n")


@pytest.mark.wheel
@pytest.mark.parametrize("extra", COMMANDS)
def test_an_extra_alone_brings_what_its_commands_need(installed, tmp_path, extra):
    command = installed(extra).with_name("swarm-forage")
    for arguments in COMMANDS[extra]:
        run_plain(command, *arguments, cwd=tmp_path)
