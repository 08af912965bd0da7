"""Experiments of a paper: how they are set up, and how samples are drawn from their episodes."""

from types import SimpleNamespace

import pytest

from baselines.papers.experiments import (
    CrossValidatedBest,
    Experiment,
    Pool,
    not_all_recruited,
    on_path,
    recruitment_time,
    round_trips,
    sample,
)
from baselines.papers.figures import (
    Boxes,
    Curves,
    controllers_of,
    recruitment_time_if_finished,
    time_of_each_robot,
)
from baselines.papers.paper import Paper
from baselines.papers.reproduction import results_of
from swarm_forage_env.errors import ConfigError

A, B, C = Experiment("es1", "nc"), Experiment("es1", "ssgikf"), Experiment("es1", "dsgikf")


def test_an_experiment_is_configured_with_its_own_settings_above_the_ones_of_all():
    experiment = Experiment("es1", "nc", ("task.n_robots=5",))
    found = experiment.configuration(None, ["task.n_robots=7", "task.duration=60"])
    assert (found.scenario.task.n_robots, found.scenario.task.duration) == (5, 60.0)
    assert (found.label, found.physics) == ("nc", "rigid")
    assert experiment.configuration("kinematic").physics == "kinematic"
    assert Experiment("waypoints-05-authors", "boids-goal").configuration(None).physics != "rigid"


def test_a_wrong_setting_is_refused_by_the_name_of_its_option():
    with pytest.raises(ConfigError, match="--set: "):
        A.configuration(None, ["task.n_robots=0"])


def test_a_pool_is_the_mean_of_its_sources_seed_by_seed(episodes):
    results = {A: episodes(A, [10, 20, 60]), B: episodes(B, [30, 60, 20])}
    assert sample(results, Pool((A, B)), round_trips) == [20.0, 40.0, 40.0]
    assert sample(results, A, round_trips) == [10.0, 20.0, 60.0]
    assert Pool((A, B)).experiments == (A, B)


def test_metrics_are_the_numbers_of_an_episode(episodes):
    done, not_done = episodes(
        A, [7, 8], on_path_share=[0.25, 0.5], recruitment_time_s=[300.0, None]
    )
    assert [round_trips(each) for each in (done, not_done)] == [7.0, 8.0]
    assert [on_path(each) for each in (done, not_done)] == [0.25, 0.5]
    assert [recruitment_time(each) for each in (done, not_done)] == [300.0, 1000.0]
    assert [not_all_recruited(each) for each in (done, not_done)] == [0.0, 1.0]
    assert recruitment_time_if_finished(done) == 300.0
    assert recruitment_time_if_finished(not_done) != recruitment_time_if_finished(not_done)


@pytest.mark.parametrize(
    ("one", "other", "choices", "drawn"),
    [
        ([1], [2], [1], [2]),  # of one seed the best itself
        ([2], [1], [0], [2]),
        ([5, 1], [4, 2], [1, 0], [4, 1]),  # the best of the other seed
        ([9, 0, 9], [1, 5, 1], [1, 0], [1, 0, 1]),
        ([6, 6, 6, 6], [1, 9, 9, 1], [0, 0], [6, 6, 6, 6]),
        ([6, 6, 6, 6], [9, 1, 9, 9], [0, 1], [6, 1, 6, 9]),
    ],
)
def test_the_best_for_a_half_of_the_seeds_is_chosen_on_the_other_half(
    episodes, one, other, choices, drawn
):
    results = {A: episodes(A, one), B: episodes(B, other)}
    best = CrossValidatedBest((A, B))
    assert best.choices(results) == choices
    assert [each.round_trips for each in best.draw(results)] == drawn


def test_a_paper_runs_each_experiment_once_and_those_of_most_robot_steps_first():
    """Robots times seconds: 600, 2,000, 1,000 and 500."""
    wanted = [
        Experiment("es1", "nc", (f"task.n_robots={n}", f"task.duration={seconds}"))
        for n, seconds in ((2, 300), (10, 200), (20, 50), (5, 100))
    ]
    claims = tuple(SimpleNamespace(experiments=(each,)) for each in (*wanted, wanted[0]))
    order = Paper("name", claims, (), 3, {}).experiments
    assert order == (wanted[1], wanted[2], wanted[0], wanted[3])


def test_a_controller_is_named_without_what_differs_among_its_experiments():
    steep, flat = Experiment("es1", "ssgiff:beta=1"), Experiment("es2", "ssgiff:beta=0.1")
    series = [("one", steep), ("two", steep), ("two", steep), ("both", steep), ("both", flat)]
    best = "best", CrossValidatedBest((steep, flat))
    assert controllers_of([*series, best]) == {
        "one": "ssgiff:beta=1", "two": "ssgiff:beta=1", "both": "ssgiff", "best": "ssgiff",
    }  # fmt: skip


def test_the_episodes_of_a_plan_are_shared_out_by_experiment():
    plan = SimpleNamespace(by_configuration=lambda: [["a0", "a1"], ["b0", "b1"], ["c0", "c1"]])
    assert results_of(plan, (A, B, C)) == {A: ["a0", "a1"], B: ["b0", "b1"], C: ["c0", "c1"]}


def test_the_time_of_the_kth_robot_is_the_whole_run_where_there_was_none(episodes):
    curve = time_of_each_robot(
        episodes(A, [1, 1], recruited_at_s=[(100.0, 250.0), (1.0, 2.0, 3.0, 4.0)])
    )
    assert curve.x.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert curve.mean.tolist() == [50.5, 126.0, 501.5, 502.0]


@pytest.fixture
def drawn(monkeypatch):
    """What a figure hands to the drawing of its panels."""
    from baselines.papers import figures

    given = []
    for name in ("box_panels", "curve_panels"):
        monkeypatch.setattr(figures, name, lambda *arguments: given.append(arguments))
    return given


def test_boxes_hold_the_values_of_each_series_that_has_one(episodes, drawn):
    results = {
        A: episodes(A, [1, 2, 3], recruitment_time_s=[300.0, None, 500.0]),
        B: episodes(B, [4, 5, 6], recruitment_time_s=[100.0, 200.0, 300.0]),
    }
    panels = {"es1": {"NC": {"": A}, "SGIKF": {"": B}}, "es2": {"x": {"one": A, "two": B}}}
    boxes = Boxes("name", "Time.", ("x", "y"), panels, recruitment_time_if_finished)
    boxes.draw(results, "a command")
    ((found, axes, caption, controllers),) = drawn
    assert found == {
        "es1": {"NC": {"": [300.0, 500.0]}, "SGIKF": {"": [100.0, 200.0, 300.0]}},
        "es2": {"x": {"one": [300.0, 500.0], "two": [100.0, 200.0, 300.0]}},
    }
    assert axes == ("x", "y")
    assert (caption.text, caption.n) == (f"Time. {boxes.reading}", 3)
    assert (caption.command, caption.note) == ("a command", "n = 3 episodes each")
    assert controllers == {"NC": "nc", "SGIKF": "ssgikf", "one": "nc", "two": "ssgikf"}
    assert boxes.experiments == (A, B, A, B)


def test_curves_are_made_of_the_episodes_of_each_series(episodes, drawn):
    results = {A: episodes(A, [1, 2]), B: episodes(B, [4, 5])}
    panels = {"es1": {"NC": A, "SGIKF": B}, "es2": {"NC": A}}
    trips = Curves(
        "name", "Trips.", ("x", "y"), panels, lambda drawn: [each.round_trips for each in drawn]
    )
    trips.draw(results, "a command")
    ((found, axes, _, controllers),) = drawn
    assert found == {"es1": {"NC": [1, 2], "SGIKF": [4, 5]}, "es2": {"NC": [1, 2]}}
    assert axes == ("x", "y")
    assert controllers == {"NC": "nc", "SGIKF": "ssgikf"}
    assert trips.experiments == (A, B, A)
