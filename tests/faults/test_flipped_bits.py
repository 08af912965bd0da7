"""One flipped bit in any kept file: the same content, or a refusal in one line."""

from dataclasses import replace

import numba
import numpy as np
import pytest

from baselines.evaluation.dataset import Dataset
from baselines.evaluation.dataset_reader import read_groups
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from swarm_forage_env.compiler import _bound, bind, kernel
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.kernel_cache import cache_folder
from swarm_forage_env.scenarios import find_scenario
from tests.evaluation.conftest import EPISODE
from training.checkpoint import read_checkpoint, write_checkpoint
from training.policy_file import BUNDLED, load_policy

pytestmark = pytest.mark.faults


def dataset(folder):
    kept = Dataset(folder)
    kept.open()
    configuration = ExperimentConfig("nc", find_scenario("es1"), find_layered_controller("nc"))
    kept.keep(configuration, [replace(EPISODE, controller="nc", physics="rigid")])
    return kept.place(configuration, 3), lambda: read_groups([str(folder)])


def checkpoint(folder):
    file = folder / "checkpoint.safetensors"
    arrays = {"means": np.arange(60, dtype=np.float32).reshape(20, 3), "losses": np.ones((4, 5))}
    write_checkpoint(file, {"seed": "3"}, [], arrays)

    def read():
        curve, found = read_checkpoint(file, {"seed": "3"})
        return curve, {name: array.tobytes() for name, array in found.items()}

    return file, read


def policy(folder):
    file = folder / "motion.safetensors"
    for ending in (".safetensors", ".json"):
        part = BUNDLED / f"motion{ending}"
        file.with_suffix(ending).write_bytes(part.read_bytes())
    return file, lambda: {name: each.tobytes() for name, each in load_policy(file).weights.items()}


KINDS = {dataset: 1500, checkpoint: 1000, policy: 1000}
"""Kinds of files, and how many bits of each are flipped where FAULTS is 100."""


def flipped(content, rng):
    """The content with one bit turned."""
    bit, changed = rng.randrange(8 * len(content)), bytearray(content)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


@pytest.mark.parametrize("kind", KINDS)
def test_a_flipped_bit_changes_nothing_in_silence(kind, tmp_path, tries, rng, tell):
    file, read = kind(tmp_path)
    content, sound = file.read_bytes(), read()
    refused, silent = [], 0
    for _ in range(tries(KINDS[kind])):
        file.write_bytes(flipped(content, rng))
        try:
            silent += read() != sound
        except ConfigError as refusal:
            refused.append(str(refusal))
    tried = tries(KINDS[kind])
    assert not silent
    assert not [each for each in refused if "\n" in each]
    tell(tried=tried, refused=len(refused), same=tried - len(refused), failed=silent)


def raise_all(numbers):
    """A template: the free name is what each number becomes."""
    for k in range(numbers.shape[0]):
        numbers[k] = raised(numbers[k])


@kernel
def raised(x):
    return x + 1.0


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_a_flipped_bit_of_machine_code_makes_it_be_compiled_again(
    tmp_path, monkeypatch, tries, rng, tell
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def total():
        _bound.cache_clear()
        made, numbers = bind(raise_all, {"raised": raised}), np.zeros(3)
        made(numbers)
        assert numbers.tolist() == [1.0, 1.0, 1.0]
        return sum(made.stats.cache_hits.values())

    assert total() == 0
    assert total() == 1
    hits = 0
    for _ in range(tries(500)):
        file = rng.choice(sorted(cache_folder().iterdir()))
        file.write_bytes(flipped(file.read_bytes(), rng))
        hits += total()
    assert hits == 0
    tell(tried=tries(500), compiled_again=tries(500), failed=hits)
