"""The ladder's figures, page and list, number by number, on runs worked by hand."""

from dataclasses import replace

import numpy as np
import pytest

from training.ladder import figures, page
from training.ladder.figures import TAUS
from training.ladder.rungs import RANDOM, Card, Rung, Score, read_algorithms
from training.ladder.runs import Job, Run

CARD = Card(
    rung=3, title="Tiny", hard="Nothing.", controllers=("nc", "ssgikf"), also=(),
    scores={RANDOM: Score(mean=2.0, low=1.0, high=3.0, episodes=30),
            "nc": Score(mean=4.0, episodes=30), "ssgikf": Score(mean=6.0, episodes=30),
            "no-error": Score(mean=12.0, low=11.4, high=12.6, episodes=30)},
)  # fmt: skip
KEYWORDS = {"scenario": "es1", "learn": "motion", "physics": "kinematic", "task.n_robots": 3}


@pytest.fixture
def rung(tmp_path):
    return Rung("tiny", tmp_path / "tiny.yaml", KEYWORDS, CARD)


def run_of(algorithm="sb3_ppo", seed=0, score=7.0):
    curve = [
        {"robot_steps": 1_000_000, "wall_s": 30.0, "scores": [score - 3.0, score - 1.0]},
        {"robot_steps": 2_500_000, "wall_s": 90.0 + 60.0 * seed, "scores": [score, score]},
    ]
    results = curve, (score,), (score,), {"numpy": "2"}
    return Run("tiny", algorithm, seed, "key", {}, 2_500_000, 90.0, *results)


@pytest.fixture
def drawn(monkeypatch):
    """What is drawn on each panel: the title of an algorithm and its means."""
    found = []
    monkeypatch.setattr(
        figures, "draw_band", lambda axes, title, means, style: found.append((title, means))
    )
    return found


def test_the_curves_of_a_rung_run_over_million_steps_and_minutes(rung, drawn):
    runs = [run_of(seed=0), run_of(seed=1, score=9.0), run_of(seed=2, score=8.0)]
    figure = figures.curves(rung, [*runs, run_of("mappo", score=5.0)], "a command")
    titles = [read_algorithms()[name].title for name in ("sb3_ppo", "mappo")]
    assert [title for title, _ in drawn] == titles * 2
    of_steps, alone, of_time, _ = (means for _, means in drawn)
    assert of_steps.x.tolist() == [1.0, 2.5]
    assert of_time.x.tolist() == [0.5, 2.5]  # the median time: 150 s
    # Interquartile means of three runs leave none out: 5, 7, 6 and 7, 9, 8.
    for means in (of_steps, of_time):
        assert means.mean.tolist() == pytest.approx([6.0, 8.0])
        assert (means.low < means.mean).all()
        assert (means.high > means.mean).all()
    assert alone.mean.tolist() == alone.low.tolist() == alone.high.tolist() == [3.0, 5.0]
    first, second = figure.axes
    assert first.get_xlim()[0] == second.get_xlim()[0] == 0.0
    assert (first.get_title(loc="left"), second.get_title(loc="left")) == ("Tiny", "")
    assert first.get_ylim() == second.get_ylim() == (0.0, pytest.approx(1.05 * 12.0))
    assert "Rung 3, tiny." in figure.caption.text
    assert figure.caption.note == "n = 1 to 3 seeds of training"
    assert figure.caption.command == "a command"


def test_a_curve_has_the_evaluations_that_all_runs_have(rung, drawn):
    short = run_of(seed=1)
    figures.curves(rung, [run_of(), replace(short, curve=short.curve[:1])], "")
    assert [len(means.x) for _, means in drawn] == [1, 1]
    drawn.clear()
    figure = figures.curves(rung, [run_of(), run_of(seed=1)], "")
    assert figure.caption.note == "n = 2 seeds of training"


def test_what_others_score_is_a_line_that_the_last_panel_names_in_order(rung, drawn):
    figure = figures.curves(rung, [run_of()], "a command")
    for axes in figure.axes:
        assert [line.get_ydata()[0] for line in axes.lines] == [2.0, 4.0, 6.0, 12.0]
    first, second = figure.axes
    assert not first.texts
    names = {text.get_text(): text.xy for text in second.texts}
    assert list(names) == [RANDOM, "nc", "ssgikf", "no-error"]
    for name, score in (("random", 2.0), ("nc", 4.0), ("ssgikf", 6.0), ("no-error", 12.0)):
        assert names[name] == (1.01, pytest.approx(score / 12.6))


def test_names_of_lines_that_lie_close_are_pushed_apart(rung, drawn):
    scores = {RANDOM: Score(mean=0.0), "nc": Score(mean=0.1), "ssgikf": Score(mean=0.2),
              "no-error": Score(mean=10.0)}  # fmt: skip
    close = replace(rung, card=CARD.model_copy(update={"scores": scores}))
    figure = figures.curves(close, [run_of()], "")
    heights = [text.xy[1] for text in figure.axes[1].texts]
    assert heights == pytest.approx([0.0, 0.045, 0.09, 10.0 / 10.5])


def test_a_profile_is_the_share_of_runs_above_each_score_in_per_cent(rung, drawn):
    runs = [run_of(seed=0, score=2.0), run_of(seed=1, score=7.0), run_of(seed=2, score=12.0)]
    figure = figures.profiles([rung], runs, "a command")
    ((_, means),) = drawn  # normalised: 0, 0.5 and 1
    assert means.x.tolist() == TAUS.tolist()
    assert (TAUS[0], TAUS[-1], len(TAUS)) == (0.0, 1.5, 61)
    share = dict(zip(np.round(TAUS, 3).tolist(), means.mean.tolist(), strict=True))
    assert [share[tau] for tau in (0.0, 0.475, 0.5, 0.975, 1.0, 1.5)] == pytest.approx(
        [200 / 3, 200 / 3, 100 / 3, 100 / 3, 0.0, 0.0]
    )
    assert means.low.min() == 0.0
    assert means.high.max() == 100.0
    assert figure.axes[0].get_xlim() == (0.0, 1.5)
    assert figure.caption.text.startswith("Runs of tiny, ")


def test_a_job_is_as_long_as_its_rung_says_an_algorithm_takes(rung):
    algorithm = next(iter(read_algorithms().values())).model_copy(update={"share": 0.25})
    assert Job(rung, algorithm, 0).robot_steps == 250_000
    assert Job(rung, algorithm, 0, 1234).robot_steps == 1234


def test_defaults_are_told_seed_by_seed_and_how_many_beat_the_hand_written(rung):
    """And the median of the evaluations nearest to half of the robot-steps: 3, 7 and 4."""
    runs = [run_of(seed=k, score=score) for k, score in enumerate((5.0, 9.0, 6.0))]
    runs[:2] = [replace(run, scores_kinematic=[run.score, 9.0]) for run in runs[:2]]
    heads, best, rest = page.defaults_lines(rung, [*runs, run_of("qmix", score=12.0)])
    assert heads[5] == "above ssgikf"
    assert best[:6] == ("QMIX", "12", "12", "12.0", "12.0", "1 of 1")
    assert rest[:6] == ("PPO (SB3)", "5 9 6", "5 9 6", "6.0", "5.0", "1 of 3")
    assert rest[6:] == ("4", "2 min", "7 9", "-")


def test_a_rung_without_scores_has_an_axis_as_high_as_its_curves(rung):
    bare = replace(rung, card=CARD.model_copy(update={"scores": {}}))
    figure = figures.curves(bare, [run_of(score=0.1, algorithm="mappo")], "")
    assert not figure.axes[0].texts
    for axes in figure.axes:
        assert axes.get_ylim()[0] == 0.0
        assert 0.1 < axes.get_ylim()[1] < 0.5


def test_no_two_algorithms_of_a_figure_look_alike():
    names = sorted(read_algorithms(), key=lambda name: name[::-1])
    styles = figures._styles({name: [] for name in names})
    assert len(set(styles.values())) == len(names) > 10
    assert len({style.colour for style in list(styles.values())[:10]}) == 10
