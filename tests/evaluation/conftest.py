"""Small episodes: es1, cut short; and one that was never run."""

import io
from dataclasses import replace

import pytest
from matplotlib.text import Text
from rich.console import Console

from baselines.evaluation.dataset import Dataset
from baselines.evaluation.episode import run_episodes
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from swarm_forage_env.foraging.episode import ForagingEpisode
from swarm_forage_env.scenarios import find_scenario


@pytest.fixture
def configuration():
    return configure()


@pytest.fixture
def new_dataset(tmp_path):
    """Make a dataset in a folder of this name."""

    def make(name):
        dataset = Dataset(tmp_path / name)
        dataset.open()
        return dataset

    return make


@pytest.fixture
def dataset(new_dataset):
    return new_dataset("kept")


def timeless(episodes):
    """Episodes without how long they took."""
    return [replace(episode, wall_s=0.0) for episode in episodes]


def run(configuration, seeds, threads=1):
    """The episodes of a configuration, without how long they took."""
    what = configuration.scenario, configuration.controller, seeds, configuration.physics
    return timeless(run_episodes(*what, threads))


def printed(what, width=80):
    """What a terminal of this width shows."""
    console = Console(file=io.StringIO(), width=width)
    console.print(what)
    return console.file.getvalue()


def configure(controller="ssgikf", physics="kinematic", **settings):
    """A configuration of es1 over 20 s, with settings like task_duration=30."""
    values = {"task.duration": 20.0}
    values |= {name.replace("_", ".", 1): value for name, value in settings.items()}
    scenario = find_scenario("es1", values)
    return ExperimentConfig(controller, scenario, find_layered_controller(controller), physics)


@pytest.fixture(name="configure")
def _configure():
    return configure


EPISODE = ForagingEpisode(
    scenario="es1",
    controller="ssgikf",
    seed=3,
    physics="kinematic",
    n_robots=10,
    duration_s=20.0,
    round_trips=12,
    recruitment_time_s=None,
    on_path_share=1 / 3,
    lost_events=4,
    messages=567,
    localisation_error_m=0.1 + 0.2,
    wall_s=1.5,
    on_path_over_time=(0.0, 0.1, 0.3),
    recruited_at_s=(7.5, 19.0),
)
"""A made-up one."""


@pytest.fixture
def episode():
    return EPISODE


@pytest.fixture
def texts_at_fault():
    """The texts of a figure that lie on each other or outside of the page."""

    def find(figure):
        figure.draw_without_rendering()
        beyond = _beyond(figure)
        texts = [text for text in figure.findobj(Text) if text.get_text().strip()]
        shown = [text for text in texts if text.get_visible() and text not in beyond]
        assert len(shown) > 5
        boxes = [(text.get_text(), text.get_window_extent()) for text in shown]
        page = figure.bbox.padded(1.0)
        outside = [
            name
            for name, box in boxes
            if not (page.contains(box.x0, box.y0) and page.contains(box.x1, box.y1))
        ]
        return outside + [
            (name, other)
            for number, (name, box) in enumerate(boxes)
            for other, second in boxes[:number]
            if box.padded(-2.0).overlaps(second)
        ]

    return find


def _beyond(figure):
    """Labels of ticks beyond the ends of their axes, which are not drawn."""
    return {
        label
        for axes in figure.axes
        for axis in (axes.xaxis, axes.yaxis)
        for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]
        if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
        for label in (tick.label1, tick.label2)
    }
