"""What a reader is told of the episodes."""

import csv
import io
import json
from dataclasses import asdict, replace
from types import SimpleNamespace

import pytest
from rich.text import Text

from baselines.evaluation.tables import FittingTable, noise_lines, report, to_csv, to_json
from tests.evaluation.conftest import printed


@pytest.fixture
def episodes(episode):
    """Episodes of a controller with these round trips."""

    def make(controller, trips):
        return [
            replace(episode, controller=controller, seed=seed, round_trips=count)
            for seed, count in enumerate(trips)
        ]

    return make


def test_the_series_are_told_only_if_asked_for(episodes):
    listed = episodes("nc", [3])
    (told,), (asked,) = json.loads(to_json(listed)), json.loads(to_json(listed, series=True))
    assert asked == asdict(listed[0]) | {
        "overrides": "",
        "on_path_over_time": [0.0, 0.1, 0.3], "recruited_at_s": [7.5, 19.0],
    }  # fmt: skip
    assert set(asked) - set(told) == {"on_path_over_time", "recruited_at_s"}
    assert "on_path" not in to_csv(listed).replace("on_path_share", "")


def test_csv_has_a_line_to_an_episode_and_nothing_for_what_is_missing(episodes):
    told = to_csv(episodes("nc", [3, 4]), ["radio.frames=1", "task.n_robots=5"])
    lines = list(csv.DictReader(io.StringIO(told)))
    assert lines[0]["overrides"] == "radio.frames=1 task.n_robots=5"
    assert [line["round_trips"] for line in lines] == ["3", "4"]
    assert lines[0]["recruitment_time_s"] == ""
    assert float(lines[0]["localisation_error_m"]) == 0.1 + 0.2


def test_the_table_shows_means_with_intervals_and_the_comparison(episodes):
    text = printed(report(episodes("nc", [10, 12, 14, 16]) + episodes("ssgikf", [30, 31, 35, 36])))
    words = "13.0", "33.0", "Round trips against nc", "20.0 (", "2.54 (", "0.029"
    for each in words:  # the last is p: 2 of 70 rankings
        assert each in text
    assert "sound" not in text
    assert ": 1 robot, " in printed(report([replace(episodes("nc", [5])[0], n_robots=1)]))


def test_a_difference_about_zero_has_an_interval_that_is_not_rounded_to_zero(episodes):
    text = printed(report(episodes("nc", [1, 2, 3, 2]) + episodes("ssgikf", [2, 1, 3, 2])))
    assert "0.00 (-1.30 to 1.30)" in text


@pytest.mark.parametrize("trips", [[0, 0, 0], [5, 5, 5], [5]])
def test_equal_values_have_no_interval(episodes, trips):
    text = printed(report(episodes("nc", trips) + episodes("ssgikf", trips)))
    assert "n/a" in text
    assert "nan" not in text.lower()


def test_a_mean_over_part_of_the_episodes_says_over_how_many(episodes):
    times = zip(episodes("nc", [1, 2, 3, 4]), (None, 0.0, 100.0, 110.0), strict=True)
    some = [replace(each, recruitment_time_s=time) for each, time in times]
    text = printed(report(some, ["radio.frames=1"]))
    assert "n = 3 of 4" in text
    assert "-81.1 to 221.1" in text
    assert "the others have no value" in text
    assert ", radio.frames=1:" in text


LONG = "ssgikf-sceptical:agreement=0.4,slack=0.5"
NAMES = "nc", LONG, "social_odometry+my_rule+subsumption"
SOUND = {
    "sound_robots": 8, "round_trips_sound": 111, "on_path_share_sound": 0.515,
    "lost_events_sound": 345, "localisation_error_sound_m": 0.2345,
}  # fmt: skip


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_every_row_is_named_in_every_table(episodes, width):
    faulty = [
        replace(each, messages=9000 * each.seed,
                **{key: value * (1 + each.seed / 10) for key, value in SOUND.items()})
        for name in NAMES
        for each in episodes(name, [100, 137, 174])
    ]  # fmt: skip
    text = printed(report(faulty), width)
    assert "…" not in text
    _, *tables = text.split("controller ")
    assert len(tables) >= 3, "of all robots, of those without a fault, and the comparison"
    for table in tables:
        assert LONG in table or all(f" {part}" in table for part in ("agreement=0.4,", "slack=0.5"))
        assert "+my_rule" in table
    assert "Of the robots without a fault" in text


def test_columns_without_room_follow_below_beside_the_names():
    columns = {f"column {k}": [Text("123.4-234.5"), Text("n/a")] for k in range(6)}
    text = printed(FittingTable("controller", ["nc", "ssgikf"], columns), 50)
    assert text.count("ssgikf") == text.count("controller") == 2
    assert text.count("123.4-234.5") == 6
    assert max(map(len, text.splitlines())) <= 50
    assert printed(FittingTable("controller", ["nc", "ssgikf"], columns), 120).count("ssgikf") == 1


def test_a_name_is_broken_at_its_marks_only_where_it_must_be():
    columns = {"score": [Text("1")]}
    assert LONG in printed(FittingTable("controller", [LONG], columns), 80)
    narrow = printed(FittingTable("controller", [LONG], columns), 30)
    assert [line.strip().removesuffix("1").strip() for line in narrow.splitlines()[1:]] == [
        "ssgikf-sceptical:", "agreement=0.4,", "slack=0.5",
    ]  # fmt: skip


@pytest.fixture
def lines(episode):
    """The lines of policies: chance or None for a hand-written controller, and round trips."""

    def lines_of(*rows):
        parameters = [
            {"beta": 1.0} if chance is None else {"policy.chance": chance} for chance, _ in rows
        ]
        configurations = [
            SimpleNamespace(label=f"policy{k}", controller=SimpleNamespace(parameters=each))
            for k, each in enumerate(parameters)
        ]
        episodes = [[replace(episode, round_trips=n) for n in trips] for _, trips in rows]
        return list(noise_lines(configurations, episodes))

    return lines_of


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([(False, [240, 0, 250])], ["differ by 142 round trips"]),
        ([(False, [240, 200, 235])], []),
        ([(False, [1000, 1100])], []),
        (
            [(False, [70, 80]), (True, [160, 170])],
            ["it makes 75 round trips without, and 165 with"],
        ),
        ([(False, [150, 150]), (True, [160, 170])], []),
        ([(True, [240, 0]), (None, [240, 0])], []),
        ([(False, [5])], []),
    ],
)
def test_it_is_told_by_episodes_that_differ_and_by_a_score_far_below_that_with_noise(
    lines, rows, message
):
    told = lines(*rows)
    assert len(told) == len(message)
    for line, part in zip(told, message, strict=True):
        assert line.startswith("policy policy0 searches by its noise: ")
        assert part in line
        assert line.endswith("; compare it with policy0,chance=true")
