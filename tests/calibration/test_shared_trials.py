"""Trials in a database that several processes share, and addresses that are none."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("optuna")
import optuna

from calibration.kept import checked_trials, trials_address
from calibration.search import ENDED
from swarm_forage_env.errors import ConfigError

ROOT = Path(__file__).resolve().parents[2]
TRIALS = 24

SEARCH = """
import math, sys
from pathlib import Path
from calibration.ranges import RANGES, defaults
from calibration.search import Search
from calibration.targets import TARGETS

def valley(values, arena):
    off = sum(abs(values[each.name] - defaults()[each.name] * 0.9) for each in RANGES)
    return {each: each.value * math.exp(0.01 * off) for each in TARGETS if each.source == arena}

folder, seed, address = sys.argv[1:]
search = Search(Path(folder), valley, "stub", int(seed), address)
search.run(TRIALS, None, print)
search.close()
""".replace("TRIALS, None", f"{TRIALS}, None")


def start(folder, seed, address):
    return subprocess.Popen(
        [sys.executable, "-c", SEARCH, str(folder), str(seed), address],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def test_two_processes_search_together_in_one_database(tmp_path):
    address = f"sqlite:///{tmp_path / 'shared.sqlite'}"
    runs = [start(tmp_path / str(seed), seed, address) for seed in (1, 2)]
    told = []
    for run in runs:
        stdout, stderr = run.communicate(timeout=300)
        assert run.returncode == 0, stderr
        told.append({line.partition(":")[0] for line in stdout.splitlines()})
    study = optuna.load_study(study_name="stub", storage=address)
    ended = study.get_trials(states=ENDED)
    assert TRIALS <= len(ended) <= TRIALS + 1, "one may end while the other runs its last"
    assert len(ended) == len(study.trials), "none was broken off by the other process"
    assert told[0] | told[1] == {f"trial {each.number}" for each in ended}
    assert told[0], "the first had a share"
    assert told[1], "the second had a share"
    assert not told[0] & told[1], "no trial was run by both"
    tried = [tuple(each.params.values()) for each in ended]
    assert len(set(tried)) >= TRIALS - 1, "both may begin with the defaults"


@pytest.mark.parametrize(
    ("address", "complaint"),
    [
        ("trials.sqlite", "--storage=trials.sqlite: Could not parse SQLAlchemy URL"),
        ("nonsense://x/y", "--storage=nonsense://x/y: Can't load plugin"),
        ("mysql+pymysql://me:secret@x/y", r"--storage=mysql\+pymysql://me:\*\*\*@x/y: No module"),
    ],
)
def test_an_address_that_is_none_is_refused_in_one_line(address, complaint):
    with pytest.raises(ConfigError, match=complaint) as refusal:
        trials_address(Path("trials.sqlite"), address)
    assert "\n" not in str(refusal.value)
    assert "secret" not in str(refusal.value)


def test_a_database_that_fails_is_named_without_its_password(tmp_path):
    from sqlalchemy.exc import OperationalError

    with (
        pytest.raises(OSError, match=r"^postgresql://me:\*\*\*@x/y: cannot be read or written"),
        checked_trials("postgresql://me:secret@x/y"),
    ):
        raise OperationalError("SELECT", {}, Exception("no route"))
