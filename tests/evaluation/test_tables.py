"""What a reader is told of the episodes."""

import csv
import io
import json
from dataclasses import asdict, replace

import pytest
from rich.console import Console

from baselines.evaluation.tables import report, to_csv, to_json


@pytest.fixture
def episodes(episode):
    """Episodes of a controller with these round trips."""

    def make(controller, trips):
        return [
            replace(episode, controller=controller, seed=seed, round_trips=count)
            for seed, count in enumerate(trips)
        ]

    return make


def shown(listed, width=80):
    console = Console(file=io.StringIO(), width=width)
    console.print(report(listed))
    return console.file.getvalue()


def test_json_is_one_array_of_episodes(episodes):
    listed = episodes("nc", [3, 4])
    told = json.loads(to_json(listed))
    assert [each["round_trips"] for each in told] == [3, 4]
    assert told[0]["recruitment_time_s"] is None


def test_the_series_are_told_only_if_asked_for(episodes):
    listed = episodes("nc", [3])
    (told,), (asked,) = json.loads(to_json(listed)), json.loads(to_json(listed, series=True))
    assert asked == asdict(listed[0]) | {
        "on_path_over_time": [0.0, 0.1, 0.3], "recruited_at_s": [7.5, 19.0],
    }  # fmt: skip
    assert set(asked) - set(told) == {"on_path_over_time", "recruited_at_s"}
    assert "on_path" not in to_csv(listed).replace("on_path_share", "")


def test_csv_has_a_line_to_an_episode_and_nothing_for_what_is_missing(episodes):
    lines = list(csv.DictReader(io.StringIO(to_csv(episodes("nc", [3, 4])))))
    assert [line["round_trips"] for line in lines] == ["3", "4"]
    assert lines[0]["recruitment_time_s"] == ""
    assert float(lines[0]["localisation_error_m"]) == 0.1 + 0.2


def test_the_table_shows_means_with_intervals_and_the_comparison(episodes):
    text = shown(episodes("nc", [10, 12, 14, 16]) + episodes("ssgikf", [30, 31, 35, 36]))
    assert "13.0" in text
    assert "33.0" in text
    assert "Round trips against nc" in text
    assert "20.0 (" in text
    assert "2.54 (" in text
    assert "0.029" in text, "2 of 70 rankings"


def test_a_single_episode_has_no_interval(episodes):
    text = shown(episodes("nc", [10]) + episodes("ssgikf", [30]))
    assert "n/a" in text
    assert "nan" not in text.lower()


@pytest.mark.parametrize("trips", [[0, 0, 0], [5, 5, 5]])
def test_equal_values_have_no_interval(episodes, trips):
    text = shown(episodes("nc", trips) + episodes("ssgikf", trips))
    assert "n/a" in text
    assert "nan" not in text.lower()


def test_a_mean_over_part_of_the_episodes_says_over_how_many(episodes):
    some = episodes("nc", [1, 2]) + [
        replace(each, seed=2 + k, recruitment_time_s=100.0 + 10.0 * k)
        for k, each in enumerate(episodes("nc", [3, 4, 5]))
    ]
    assert "n = 3" in shown(some)


def test_eighty_columns_hold_the_table(episodes):
    long = "ssgiff:beta=0.02,refractory=30,overshoot=0.1"
    text = shown(episodes("nc", [100, 120, 140]) + episodes(long, [300, 320, 310]))
    assert "…" not in text
    assert "beta=0.02," in text
    for heading in ("recruit-", "on path", "messages", "error [cm]"):
        assert heading in text
