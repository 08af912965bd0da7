"""The kinds of figures: what they show of a dataset, and what they need."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Polygon

import baselines.evaluation.figures  # noqa: F401 enters the kinds
from baselines.evaluation.commands import FIGURE_NAMES
from baselines.evaluation.episode import run_episodes
from baselines.evaluation.figure_page import page_style
from baselines.evaluation.figures.base import FIGURES, PlotOptions, check_options
from baselines.evaluation.figures.weights import DISAGREEMENTS, LONGEST, STEPS
from baselines.evaluation.line_plots import path_over_time, recruited_over_time
from swarm_forage_env.errors import ConfigError, UnknownNameError
from training.policy_card import save_policy_card

TRIPS = {"nc": 3, "ssgikf": 30, "ssgiff:beta=0.001": 40, "ssgiff": 50, "ssgiff:beta=1": 20}


@pytest.fixture
def keep(dataset, configure, episode):
    """Keep made-up episodes of controllers with about so many round trips."""

    def make(trips, **settings):
        for controller, level in trips.items():
            each = configure(controller, **settings)
            made = replace(episode, n_robots=each.scenario.task.n_robots)
            dataset.keep(each, [replace(made, seed=k, round_trips=level + k) for k in range(4)])
        return str(dataset.folder)

    return make


def draw(kind, *sources, **options):
    options = PlotOptions(kind, sources, **options)
    check_options(options)
    return FIGURES[kind].draw(options)


def legend(figure):
    return [text.get_text() for text in figure.legends[0].texts]


def caption(figure):
    return str(figure.caption)


def test_the_command_offers_every_kind_there_is():
    assert set(FIGURE_NAMES) == set(FIGURES)


def test_a_boxplot_has_a_box_for_each_controller_and_a_panel_for_each_setup(keep):
    keep(TRIPS)
    folder = keep({"nc": 5}, task_n_robots=5)
    figure = draw("boxplot", folder)
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "es1, task.duration=20, kinematic",
        "es1, task.duration=20, task.n_robots=5, kinematic",
    ]
    assert [len(axes.patches) for axes in figure.axes] == [5, 1]
    assert "n = 4 episodes each" in caption(figure)
    assert caption(figure).endswith(f"swarm-forage plot boxplot {folder}")


def test_another_metric_is_shown_in_its_unit_without_the_missing(keep):
    folder = keep({"nc": 3})
    figure = draw("boxplot", folder, metric="on_path_share")
    assert figure.axes[0].get_xlabel() == "on path [%]"
    medians = [line.get_xdata() for line in figure.axes[0].lines]
    assert any(np.allclose(median, 100 / 3) for median in medians)
    figure = draw("boxplot", folder, metric="recruitment_time_s")
    assert [text.get_text() for text in figure.axes[0].texts] == ["none"]


def test_the_number_that_varies_is_found_and_others_are_level_lines(keep):
    figure = draw("curve", keep(TRIPS))
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_xscale()) == ("beta [1/cm]", "log")
    assert set(legend(figure)) == {"nc", "ssgikf", "ssgiff"}
    curve = axes.containers[0].lines[0]
    assert curve.get_xdata() == pytest.approx([0.001, 0.01, 1.0])
    assert curve.get_ydata().tolist() == [41.5, 51.5, 21.5]
    levels = {line.get_label(): set(line.get_ydata()) for line in axes.lines}
    assert levels["nc"] == {4.5}
    assert levels["ssgikf"] == {31.5}
    assert "n = 4 episodes each. Code" in caption(figure)
    figure = draw("curve", str(keep({})), metric="recruitment_time_s")
    assert "n = 4 episodes each, 0 of them with a value. Code" in caption(figure)


@pytest.mark.parametrize(
    ("name", "values", "label", "first"),
    [("task_n_robots", (5, 10, 20), "robots", 0.0),
     ("radio_max_range", (0.15, 0.2), "radio range [m]", 0.1475)],
)  # fmt: skip
def test_a_number_of_the_scenario_makes_a_curve_on_an_axis_near_its_values(
    keep, name, values, label, first
):
    for value in values:
        folder = keep({"nc": 5, "ssgikf": 10}, **{name: value})
    figure = draw("curve", folder)
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_xscale()) == (label, "linear")
    assert axes.get_xlim()[0] == pytest.approx(first, abs=2e-3)
    assert legend(figure) == ["nc", "ssgikf"]


def test_a_curve_of_one_value_is_refused_with_how_to_get_more(keep):
    folder = keep({"ssgiff": 3, "nc": 1})
    for x in (None, "beta"):
        with pytest.raises(ConfigError, match=r"takes two values .* evaluate two values, as in"):
            draw("curve", folder, x=x)


def test_of_several_numbers_that_vary_one_must_be_named(keep):
    keep({"ssgiff": 3, "ssgiff:beta=1": 3})
    folder = keep({"ssgiff": 3}, task_n_robots=5)
    with pytest.raises(ConfigError, match=r"--x task\.n_robots or --x weighting\.beta"):
        draw("curve", folder)
    assert draw("curve", folder, x="beta").axes[0].get_xlabel() == "beta [1/cm]"
    with pytest.raises(UnknownNameError, match=r"did you mean 'weighting\.beta'"):
        draw("curve", folder, x="weighting.bta")


def test_shares_over_time_count_robots(episode):
    curve = recruited_over_time([episode], points=5)
    assert curve.x.tolist() == [0.0, 5.0, 10.0, 15.0, 20.0]
    assert curve.mean.tolist() == [0.0, 0.0, 10.0, 10.0, 20.0]
    assert path_over_time([episode]).mean == pytest.approx([0.0, 10.0, 30.0])


@pytest.mark.parametrize("kind", ["on-path", "recruitment"])
def test_shares_over_time_have_a_curve_for_each_controller(keep, kind):
    figure = draw(kind, keep(TRIPS))
    assert figure.axes[0].get_xlabel() == "time [s]"
    assert figure.axes[0].get_ylim() == (0.0, 102.0)
    assert len(figure.axes[0].lines) == len(figure.axes[0].collections) == len(TRIPS)


def test_a_table_crosses_motion_with_localisation_and_names_what_it_leaves_out(keep, caplog):
    trips = {
        f"{motion}:estimator={localisation}": level
        for level, motion, localisation in [
            (10, "subsumption", "dead_reckoning"),
            (20, "subsumption", "social_odometry"),
            (30, "boids-goal", "social_odometry"),
        ]
    }
    folder = keep(trips | {"nc": 1})
    axes = draw("table", folder).axes[0]
    rows, columns = (
        [label.get_text() for label in labels]
        for labels in (axes.get_yticklabels(), axes.get_xticklabels())
    )
    cells = {
        (rows[round(text.get_position()[1])], columns[round(text.get_position()[0])]):
        text.get_text().partition("\n")[0] for text in axes.texts
    }  # fmt: skip
    assert cells == {
        ("boids-goal", "social\nodometry"): "31.5",
        ("boids-goal", "dead\nreckoning"): "none",
        ("subsumption", "social\nodometry"): "21.5",
        ("subsumption", "dead\nreckoning"): "11.5",
    }
    assert "left out, because they name no localisation: nc" in caplog.text
    figure = draw("table", folder, metric="recruitment_time_s")
    assert "n = 4 episodes each, 0 of them with a value" in caption(figure)
    with pytest.raises(ConfigError, match="subsumption:estimator=dead_reckoning"):
        draw("table", folder, controllers=("nc",))


@pytest.fixture
def evaluated(dataset, configuration):
    """One episode of es1 over 20 s, truly run."""
    run = run_episodes(configuration.scenario, configuration.controller, [3], "kinematic")
    dataset.keep(configuration, run)
    return str(dataset.folder), run[0]


def test_paths_hold_every_robot_all_the_time(evaluated):
    density = draw("paths", evaluated[0]).axes[0].images[0].get_array()
    assert density.mean() * 1.7 * 1.2 == pytest.approx(10.0), "robots on 1.7 x 1.2 m2"


def test_paths_that_do_not_repeat_the_dataset_are_refused(evaluated, dataset, configuration):
    folder, episode = evaluated
    dataset.keep(configuration, [replace(episode, round_trips=99)])
    with pytest.raises(ConfigError, match="gives 0 round trips here, but 99 in the dataset"):
        draw("paths", folder)
    with pytest.raises(ConfigError, match=r"--seed 4: ssgikf in .* has 1 seed, 3 to 3"):
        draw("paths", folder, seed=4)
    older = replace(configuration)
    older.__dict__["code"] = "0123456789abcdef"
    dataset.place(configuration, 3).unlink()
    dataset.keep(older, [episode])
    with pytest.raises(ConfigError, match=r"another version .* plot paths es1 ssgikf"):
        draw("paths", folder)


def test_paths_of_a_scenario_need_its_controllers_and_walls():
    with pytest.raises(ConfigError, match="in which robots forage"):
        draw("paths", "waypoints-05-authors", "boids-goal")
    with pytest.raises(UnknownNameError, match=r"did you mean .*'ssgikf'"):
        draw("paths", "es1", "sgikf")


def card(trips=(1.0, 5.0), **changed):
    curve = [
        {"step": k, "simulated_s": 3600.0 * k, "value": level,
         "round_trips": {"es1": {"low": level - 1, "mean": level, "high": level + 1}}}
        for k, level in enumerate(trips)
    ]  # fmt: skip
    return json.dumps({"format": 1, "command": "train weighting", "curve": curve} | changed)


@pytest.fixture
def cards(tmp_path):
    """The files of two policy cards."""
    files = [tmp_path / name / "best.json" for name in ("one", "two")]
    for file in files:
        file.parent.mkdir()
        file.write_text(card())
    return list(map(str, files))


def test_learning_curves_come_from_cards_by_the_ends_of_their_names(cards):
    figure = draw("learning", cards[0], cards[1].replace(".json", ".safetensors"))
    assert legend(figure) == ["one/best", "two/best"]
    line = figure.axes[0].lines[0]
    assert (line.get_xdata().tolist(), line.get_ydata().tolist()) == ([0.0, 1.0], [1.0, 5.0])
    assert figure.axes[0].get_xlabel() == "simulated time of training [h]"
    assert "one/best: train weighting." in caption(figure)
    with pytest.raises(ConfigError, match="must be a scenario of the cards: es1"):
        draw("learning", cards[0], scenarios=("es2",))


@pytest.mark.parametrize(
    ("content", "field"),
    [("[]", ""), ("{", ""), (card(command=2), "command: .*"), (card(trips=()), "curve: .*"),
     (card(trips=(float("nan"),)), "")],
)  # fmt: skip
def test_what_is_no_card_is_refused(tmp_path, content, field):
    file = tmp_path / "best.json"
    with pytest.raises(ConfigError, match=r"No such file or directory; name a .json"):
        draw("learning", str(file))
    file.write_text(content)
    with pytest.raises(ConfigError, match=f"{field}not a card of this version"):
        draw("learning", str(file))


def test_more_curves_than_can_be_told_apart_are_refused(keep):
    folder = keep({f"ssgiff:beta={beta}": 1 for beta in range(1, 14)})
    with pytest.raises(ConfigError, match="13 curves: at most 12"):
        draw("on-path", folder)


@pytest.mark.parametrize("style", ["screen", "paper"])
def test_no_texts_overlap_or_leave_the_page(keep, texts_at_fault, cards, style):
    keep(TRIPS)
    folder = keep(TRIPS, task_n_robots=5)
    trips = {
        f"{motion}estimator={localisation}": 20
        for motion in ("subsumption:", "boids-adaptive:alignment=0.5,cohesion=0.5,trust=1.3,")
        for localisation in ("dead_reckoning", "covariance_intersection", "decentralised_ekf")
    }
    with page_style(style):
        for kind in ("boxplot", "curve", "on-path", "recruitment"):
            x = {"x": "beta"} if kind == "curve" else {}
            assert texts_at_fault(draw(kind, folder, **x)) == []
        table = draw("table", keep(trips), controllers=("subsumption", "boids-adaptive"))
        assert texts_at_fault(table) == []
        assert texts_at_fault(draw("learning", *cards)) == []
        long = "ssgiff:beta=0.001,refractory=10,pause=4,lost_within=0.06"
        maps = draw("weights", "ssgikf", long, "dsgiff-penalised", "learned-weighting")
        for axes in maps.axes:
            for label in axes.texts:  # on the contours, where they may touch
                label.remove()
        assert texts_at_fault(maps) == []


@pytest.fixture
def walled(dataset, configure):
    """One episode among a disc, a wall and a polygon, in a long arena."""
    obstacles = [
        {"points": [[0.0, 0.4]], "radius": 0.05},
        {"points": [[-0.2, -0.4], [0.2, -0.4]], "radius": 0.01},
        {"points": [[0.3, 0.3], [0.4, 0.3], [0.4, 0.4]], "radius": 0.0, "is_closed": True},
    ]
    made = configure(obstacles=obstacles, arena_length=12.0)
    dataset.keep(made, run_episodes(made.scenario, made.controller, [3], "kinematic"))
    return str(dataset.folder)


def test_paths_draw_the_obstacles_and_name_the_areas_beside_the_map(walled, texts_at_fault):
    figure = draw("paths", walled)
    assert texts_at_fault(figure) == []
    outlines = [patch for patch in figure.axes[0].patches if isinstance(patch, Polygon)]
    disc, wall, *sides = [patch.get_path().get_extents() for patch in outlines]
    assert disc.extents == pytest.approx([-0.05, 0.35, 0.05, 0.45], abs=1e-3)
    assert wall.extents == pytest.approx([-0.21, -0.41, 0.21, -0.39], abs=1e-3)
    assert sides[0].extents == pytest.approx([0.3, 0.3, 0.4, 0.4])
    assert legend(figure) == ["nest", "prey"]
    assert not figure.axes[0].texts


def maps_of(figure):
    """The weights of each map, heard paths in rows and own paths in columns."""
    return [np.asarray(axes.images[0].get_array()) for axes in figure.axes if axes.images]


def test_a_map_is_the_weight_of_each_pair_of_paths_and_rules_share_the_scale():
    figure = draw("weights", "ssgikf", "ssgiff:beta=0.01")
    panels = [axes for axes in figure.axes if axes.images]
    assert len(panels) == 2 * len(DISAGREEMENTS)
    assert {axes.images[0].get_clim() for axes in panels} == {(0.0, 1.0)}
    assert (LONGEST, STEPS) == (12.0, 61)
    own, heard = 20, 10  # 4 m and 2 m
    sgikf, sgiff = maps_of(figure)[:2]
    assert sgikf[heard, own] == pytest.approx(4.0 / (4.0 + 2.0))
    assert sgiff[heard, own] == pytest.approx(1.0 / (1.0 + np.exp(-2.0)))


def test_what_a_message_costs_is_added_to_what_the_partner_went():
    plain, wary = (maps_of(draw("weights", name))[0] for name in ("ssgiff", "dsgiff-penalised"))
    np.testing.assert_allclose(wary[:-20], plain[20:])  # 4 m


def test_labels_of_contours_stand_within_their_map():
    figure = draw("weights", "ssgikf", "ssgiff", "dsgiff-penalised", "learned-weighting")
    figure.canvas.draw()
    for axes in (each for each in figure.axes if each.images):
        frame = axes.get_window_extent()
        boxes = [label.get_window_extent() for label in axes.texts]
        assert boxes
        for box in boxes:
            assert frame.x0 <= box.x0 < box.x1 <= frame.x1
            assert frame.y0 <= box.y0 < box.y1 <= frame.y1


@pytest.mark.parametrize("beside", ["", ",controller=torchscript:motion.pt"])
def test_weights_of_a_policy_are_not_those_of_the_rule_under_it(beside, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for learn in ("weighting", "motion"):
        save_policy_card(f"{learn}.pt", "es1", learn=learn)
        Path(f"{learn}.pt").touch()
    assert maps_of(draw("weights", "torchscript:motion.pt"))
    with pytest.raises(ConfigError, match=r"a policy replaces its weighting, which 'weights' can"):
        draw("weights", f"torchscript:weighting.pt{beside}")
