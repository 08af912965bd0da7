"""The search for open parameters: its score, its ranges, trials that go on, and its database."""

import math
from types import SimpleNamespace

import pytest

from baselines.papers.claim_types import FARTHEST, Below, Number, Order, Share, miss
from baselines.papers.experiments import Experiment
from swarm_forage_env.errors import ConfigError

search = pytest.importorskip("baselines.papers.search_parameters", exc_type=SystemExit)

NC = Experiment("es1", "nc")


@pytest.mark.parametrize(
    ("claim", "ours", "expected"),
    [
        (Number("", NC, 60.0), 120.0, math.log(2.0)),
        (Number("", NC, 60.0), 30.0, math.log(2.0)),
        (Number("", NC, 60.0), None, FARTHEST),
        (Below("", NC, 50.0), 0.0, 0.0),
        (Share("", (NC,), (0.5, 0.7)), 0.25, math.log(2.0)),
        (Order("", ((NC, NC),)), 1.5, 0.0),
        (Order("", ((NC, NC),)), 1e-9, FARTHEST),
    ],
)
def test_a_claim_is_missed_by_the_log_ratio_to_its_nearest_end(claim, ours, expected):
    assert miss(claim, ours) == pytest.approx(expected)


@pytest.mark.parametrize("name", search.RANGES)
def test_both_ends_of_every_range_make_configurations_and_the_default_lies_between(name):
    ends, values = search.RANGES[name], search.defaults()
    assert ends.low <= values[name] <= ends.high
    own = {
        VALLEY.configurations(values | {name: end}, "es2")[1].key for end in (ends.low, ends.high)
    }
    assert len(own) == (1 if name.startswith(("es1", "es3")) else 2)


class Valley(search.Runner):
    """The claim of each arena is missed by how far a set is from one below the defaults."""

    def judge(self, values, arena, seeds):
        off = sum(abs(values[name] - 0.9 * default) for name, default in search.defaults().items())
        return {Number("", NC, 1.0): SimpleNamespace(ours=math.exp(0.01 * off))}


VALLEY = Valley(None, 1, "kinematic", ())


def test_a_search_begins_with_the_defaults_stops_what_is_far_off_and_goes_on(tmp_path, capsys):
    address = f"sqlite:///{tmp_path}/trials.sqlite"
    for trials in (12, 24):
        search.best_set(address, VALLEY, trials, seed=1)
    scores = [line.partition("score ")[2] for line in capsys.readouterr().err.splitlines()]
    assert len(scores) == 24
    assert not {*scores[1:6]} & {*scores[12:]}, "a search that goes on draws other sets"
    assert any("or more" in each for each in scores)
    (best,) = VALLEY.judge(search.best_set(address, VALLEY, 0, seed=1), "es1", None).values()
    assert min(scores) == f"{3 * math.log(best.ours):.3f}" <= scores[0]


def test_a_database_that_is_none_is_told_in_one_line_without_its_password():
    with pytest.raises(ConfigError, match=r"^--storage: Can't load plugin") as refusal:
        search.best_set("nonsense://me:secret@x/y", VALLEY, 1, seed=0)
    assert "secret" not in str(refusal.value)
