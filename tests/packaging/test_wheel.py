"""What a user installs: the wheel, alone in an environment, outside the checkout."""

import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {"swarm_forage_env", "baselines", "training"}
EXTRAS = (
    "imageio_ffmpeg",
    "joblib",
    "matplotlib",
    "optuna",
    "pyarrow",
    "pygame",
    "rich",
    "scipy",
    "stable_baselines3",
    "torch",
    "typer",
)

CORE_ONLY = f"""
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {EXTRAS}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Missing())
"""


def run(*command, cwd):
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of this tree; no network: the build backend comes with the extra `dev`."""
    out = tmp_path_factory.mktemp("wheel")
    flags = "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir"
    built = run(sys.executable, "-m", "pip", "wheel", *flags, out, ROOT, cwd=out)
    assert built.returncode == 0, built.stdout + built.stderr
    (path,) = out.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def environment(wheel, tmp_path_factory):
    """A new environment with the wheel; the dependencies are those of the running one."""
    home = tmp_path_factory.mktemp("environment")
    made = run(sys.executable, "-m", "venv", "--without-pip", home, cwd=home)
    assert made.returncode == 0, made.stderr
    paths = {"base": str(home), "platbase": str(home)}
    packages = Path(sysconfig.get_path("purelib", "venv", paths))
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    python = Path(sysconfig.get_path("scripts", "venv", paths)) / "python"
    flags = "--no-deps", "--no-index", "--quiet"
    pip = sys.executable, "-m", "pip", "--python", python, "install", *flags, wheel
    installed = run(*pip, cwd=home)
    assert installed.returncode == 0, installed.stdout + installed.stderr
    return python


def test_the_wheel_holds_the_three_packages_and_nothing_else(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.partition("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == PACKAGES
    assert {f"{package}/py.typed" for package in PACKAGES} <= set(names)
    assert not [name for name in names if "test" in name or "__pycache__" in name]


def test_the_wheel_holds_every_file_of_the_packages(wheel):
    files = {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert files <= set(zipfile.ZipFile(wheel).namelist())


def test_the_installed_world_is_the_wheels(environment, tmp_path):
    where = run(environment, "-c", "import swarm_forage_env as s; print(s.__file__)", cwd=tmp_path)
    assert where.returncode == 0, where.stderr
    assert Path(where.stdout.strip()).is_relative_to(environment.parents[1])


def test_the_installed_command_lists_scenarios_and_controllers(environment, tmp_path):
    listed = run(environment.with_name("swarm-forage"), "list", cwd=tmp_path)
    assert listed.returncode == 0, listed.stderr
    words = listed.stdout.split()
    assert {"es1", "ssgikf"} <= set(words)


def test_world_and_controllers_need_no_extra(environment, tmp_path):
    code = CORE_ONLY + "import swarm_forage_env, baselines.recipes"
    imported = run(environment, "-c", code, cwd=tmp_path)
    assert imported.returncode == 0, imported.stderr


def test_a_command_without_its_extra_says_in_one_line_which(environment, tmp_path):
    code = CORE_ONLY + "sys.argv = ['swarm-forage', 'list']\nimport training.cli as c\nc.main()"
    refused = run(environment, "-c", code, cwd=tmp_path)
    assert refused.returncode != 0
    assert refused.stdout == ""
    assert len(refused.stderr.splitlines()) == 1
    assert "swarm-forage[evaluate]" in refused.stderr
