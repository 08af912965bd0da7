"""What is said of the extras, where a package is missing, is what pyproject.toml has them bring."""

import re
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from swarm_forage_env.extras import EXTRAS, remedy

PYPROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"
COMMANDS = "swarm-forage[evaluate]"


@pytest.fixture(scope="module")
def declared():
    """The packages of each extra, without their versions, nor that of CUDA."""
    extras = tomllib.loads(PYPROJECT.read_text())["project"]["optional-dependencies"]
    return {
        extra: {re.split("[>=<]", each)[0].replace("[cu13]", "") for each in lines}
        for extra, lines in extras.items()
    }


@pytest.mark.parametrize("extra", EXTRAS)
def test_an_extra_brings_what_is_said_of_it_and_the_commands(declared, extra):
    of_module = packages_distributions()
    said = {
        name.replace("_", "-").lower()
        for module in EXTRAS[extra]
        for name in of_module.get(module, [module])  # torchrl has an environment of its own
    }
    alone = extra in ("evaluate", "torchrl", "cuda")
    assert declared[extra] == said | (set() if alone else {COMMANDS})


def test_what_no_extra_brings_has_no_remedy():
    assert remedy("scipy.stats") == "pip install 'swarm-forage[evaluate]'"
    assert remedy("numpy") is None
    assert remedy(None) is None
