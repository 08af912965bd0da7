"""Tables of a narrow terminal: no name of a row is cut, and no number."""

import io
from dataclasses import replace

import pytest
from rich.console import Console
from rich.text import Text

from baselines.evaluation.bench.gpu_table import gpu_table
from baselines.evaluation.fitting_table import FittingTable
from baselines.evaluation.tables import report

LONG = "ssgikf-sceptical:agreement=0.4,slack=0.5"
NAMES = "nc", LONG, "social_odometry+my_rule+subsumption"
SOUND = {
    "sound_robots": 8, "round_trips_sound": 111, "on_path_share_sound": 0.515,
    "lost_events_sound": 345, "localisation_error_sound_m": 0.2345,
}  # fmt: skip


def shown(what, width):
    console = Console(file=io.StringIO(), width=width)
    console.print(what)
    return console.file.getvalue()


def faulty(episode):
    """Episodes of the controllers in a scenario with faults."""
    return [
        replace(
            episode,
            controller=name,
            seed=seed,
            round_trips=100 + 37 * seed,
            messages=9000 * seed,
            **{key: value * (1 + seed / 10) for key, value in SOUND.items()},
        )
        for name in NAMES
        for seed in range(3)
    ]


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_every_row_is_named_in_every_table(episode, width):
    text = shown(report(faulty(episode)), width)
    assert "…" not in text
    _, *tables = text.split("controller ")
    assert len(tables) >= 3, "of all robots, of those without a fault, and the comparison"
    for table in tables:
        assert LONG in table or all(f" {part}" in table for part in ("agreement=0.4,", "slack=0.5"))
        assert "+my_rule" in table
    assert "Of the robots without a fault" in text


def test_columns_without_room_follow_below_beside_the_names():
    columns = {f"column {k}": [Text("123.4-234.5"), Text("n/a")] for k in range(6)}
    text = shown(FittingTable("controller", ["nc", "ssgikf"], columns), 50)
    assert text.count("ssgikf") == text.count("controller") == 2
    assert text.count("123.4-234.5") == 6
    assert max(map(len, text.splitlines())) <= 50
    assert shown(FittingTable("controller", ["nc", "ssgikf"], columns), 120).count("ssgikf") == 1


def test_a_name_is_broken_at_its_marks_only_where_it_must_be():
    columns = {"score": [Text("1")]}
    assert LONG in shown(FittingTable("controller", [LONG], columns), 80)
    narrow = shown(FittingTable("controller", [LONG], columns), 30)
    assert [line.strip().removesuffix("1").strip() for line in narrow.splitlines()[1:]] == [
        "ssgikf-sceptical:", "agreement=0.4,", "slack=0.5",
    ]  # fmt: skip


def test_the_table_of_a_gpu_is_whole_in_eighty_columns():
    row = {
        "case": "es1 x 65536", "gpu": 1.234e9, "environment": 5.67e8, "cpu": 3.2e6,
        "threads": 16, "shares": {"decide": 0.23, "tick": 0.5}, "bytes_per_robot_step": 1234.0,
        "bandwidth": 1.2e12, "share_of_card": None, "joules_per_million": 0.345,
        "first_step_s": 12.3,
    }  # fmt: skip
    text = shown(gpu_table([row]), 80)
    assert "…" not in text
    for part in ("es1 x 65536", "1,234", "567", "1200", "0.345", "12.3", "observe", "of card"):
        assert part in text
