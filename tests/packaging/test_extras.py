"""What is said of the extras, where a package is missing, is what pyproject.toml has them bring."""

import os
import re
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from swarm_forage_env.extras import EXTRAS, other_package, remedy
from tests.processes import run

PYPROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"
CONSTRAINTS = PYPROJECT.with_name("constraints.txt")
COMMANDS = "swarm-forage"


@pytest.fixture(scope="module")
def declared():
    """What each extra asks of every package that it brings."""
    extras = tomllib.loads(PYPROJECT.read_text())["project"]["optional-dependencies"]
    return {extra: list(map(Requirement, lines)) for extra, lines in extras.items()}


@pytest.mark.parametrize("extra", EXTRAS)
def test_an_extra_brings_what_is_said_of_it_and_the_commands(declared, extra):
    of_module = packages_distributions()
    named = {
        name.replace("_", "-").lower()
        for module in EXTRAS[extra]
        for name in of_module.get(module, [module])  # torchrl has an environment of its own
    }
    alone = extra in ("evaluate", "torchrl", "cuda")
    names = {each.name for each in declared[extra]}
    assert names - {"numpy"} == named | (set() if alone else {COMMANDS})
    assert alone or "evaluate" in declared[extra][0].extras


def test_numpy_is_one_that_the_compiler_for_gpus_can_import(declared):
    (numpy,) = (each.specifier for each in declared["cuda"] if each.name == "numpy")
    (tested,) = re.findall("^numpy==(.*)$", CONSTRAINTS.read_text(), re.MULTILINE)
    assert tested in numpy
    assert "2.5.0" not in numpy  # it has no np.row_stack


def test_what_no_extra_brings_has_no_remedy():
    assert remedy("scipy.stats") == "pip install 'swarm-forage[evaluate]'"
    assert remedy("numpy") is None
    assert remedy(None) is None


NAMESAKE = {"package": "baselines/__init__.py", "module": "baselines.py"}


@pytest.mark.parametrize("file", NAMESAKE.values(), ids=NAMESAKE)
@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("from training.cli import main\nmain()", r"^swarm-forage: another package named"),
        (
            "from swarm_forage_env import parallel_env\nparallel_env('es1')",
            r"no controller named 'ssgikf'.*another package named",
        ),
    ],
    ids=["command", "environment"],
)
def test_a_package_of_somebody_else_with_one_of_our_names_is_told(tmp_path, file, code, message):
    other = tmp_path / file
    other.parent.mkdir(exist_ok=True)
    other.write_text('"""Somebody else\'s."""\n')
    path = os.pathsep.join([str(tmp_path), str(PYPROJECT.parent)])
    _, stderr = run("-c", code, status=1, cwd=tmp_path, variables={"PYTHONPATH": path})
    last = stderr.splitlines()[-1]
    assert re.search(message, last), stderr
    place = other.parent if other.stem == "__init__" else other
    assert f"'baselines' is found first, in {place}" in last


def test_our_own_packages_are_nobody_else_s():
    assert other_package("baselines.controllers") is None
    assert other_package("training") is None
    assert other_package("numpy") is None
