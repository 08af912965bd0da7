"""The command `reproduce`, on a paper with two claims and short runs."""

import json
from types import SimpleNamespace

import pytest
from PIL import Image

from baselines.papers import time_estimate
from baselines.papers.claim_types import Number, Order
from baselines.papers.experiments import Experiment
from baselines.papers.figures import Boxes
from baselines.papers.paper import PAPERS, Paper
from baselines.papers.reproduction import ReproduceOptions, Reproduction
from baselines.papers.social_odometry import LEFT_OPEN
from baselines.papers.time_estimate import expected_seconds, format_duration, run_for
from swarm_forage_env.errors import ConfigError, UnknownNameError

NC, SSGIKF = Experiment("es1", "nc"), Experiment("es1", "ssgikf")
SHORT = "--set=task.duration=20", "--physics=kinematic", "--workers=1"


@pytest.fixture(autouse=True)
def small(monkeypatch, tmp_path):
    """In the place of the technical report, and in an empty folder."""
    claims = (Number("es1: round trips, NC", NC, 60.0), Order("order", ((SSGIKF, NC),)))
    paper_figure = Boxes("tr14", "Round trips.", ("", "trips"), {"es1": {"NC": {"": NC}}})

    def paper():
        return Paper("social-odometry", "social_odometry", claims, (paper_figure,), 30, LEFT_OPEN)

    monkeypatch.setitem(PAPERS._parts, "social-odometry", paper)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")


@pytest.fixture
def command(capsys):
    from baselines.cli import run

    def call(*arguments):
        capsys.readouterr()
        status = run(["reproduce", "social-odometry", *map(str, arguments)])
        return (status, *capsys.readouterr())

    return call


def test_json_is_the_claims_and_the_status_is_zero_though_they_fail(command, tmp_path):
    status, stdout, stderr = command("--episodes=2", "--format=json", *SHORT)
    assert status == 0
    rows = json.loads(stdout)
    assert [set(row) for row in rows] == [
        {"claim", "published", "ours", "low", "high", "reproduced"}
    ] * 2
    assert not any(row["reproduced"] for row in rows)
    assert "swarm-forage: about " in stderr
    folder = tmp_path / "runs" / "reproduce-social-odometry"
    assert json.loads((folder / "claims.json").read_text("utf-8")) == rows
    assert (folder / "social_odometry.md").exists()
    assert (folder / "figures" / "tr14.png").exists()


def test_what_has_been_run_is_not_run_again(command):
    command("--episodes=2", *SHORT)
    status, stdout, stderr = command("--episodes=3", *SHORT)
    assert status == 0
    assert "4 of 6 episodes found" in stderr
    assert "0 of 2 claims reproduced" in stdout


def test_quick_has_fewer_replications(command):
    _, _, stderr = command("--quick", *SHORT)
    assert "0 of 12 episodes found" in stderr


def test_the_page_can_be_written_elsewhere_with_its_figures(command, tmp_path):
    status, _, _ = command("--episodes=2", "--page=docs/papers/page.md", *SHORT)
    assert status == 0
    text = (tmp_path / "docs" / "papers" / "page.md").read_text("utf-8")
    command_line = "swarm-forage reproduce social-odometry --set=task.duration=20 --episodes=2"
    assert command_line in text
    assert (tmp_path / "docs" / "papers" / "figures" / "tr14.png").exists()


def test_figures_for_a_paper_are_as_broad_as_a_column_and_pdf_too(command, tmp_path):
    assert command("--episodes=2", "--style=paper", "--page=page.md", *SHORT)[0] == 0
    with Image.open(tmp_path / "figures" / "tr14.png") as image:
        assert image.width == 670
    assert (tmp_path / "figures" / "tr14.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("wrong", ["--episodes=0", "--workers=0", "--seed=-1", "--physics=soft"])
def test_nonsense_is_refused_in_one_line(command, wrong):
    status, stdout, stderr = command(wrong)
    assert (status, stdout) == (2, "")
    assert len(stderr.splitlines()) == 1


def test_an_unknown_paper_is_refused():
    with pytest.raises(UnknownNameError, match="no paper named 'ants2009'"):
        Reproduction(ReproduceOptions("ants2009"))


def test_an_unknown_setting_is_refused():
    with pytest.raises(ConfigError):
        Reproduction(ReproduceOptions("social-odometry", settings=["task.length"]))


def test_the_expected_time_grows_with_the_episodes_and_falls_with_the_workers(tmp_path):
    few, many = (
        Reproduction(
            ReproduceOptions("social-odometry", n, physics="kinematic"), tmp_path / "x"
        ).plan
        for n in (1, 100)
    )
    assert expected_seconds(many, 1) > 10.0 * expected_seconds(few, 1)
    assert expected_seconds(many, 1) > expected_seconds(many, 8)


def test_the_expected_time_is_that_of_every_tick_that_is_still_to_run(tmp_path, monkeypatch):
    monkeypatch.setattr(time_estimate, "seconds_per_tick", lambda configuration: 0.25)
    plan = Reproduction(
        ReproduceOptions("social-odometry", 3, physics="kinematic"), tmp_path / "x"
    ).plan
    configurations = {each.key: each for each in plan.configurations}
    ticks = sum(3 * each.scenario.n_ticks for each in configurations.values())
    assert expected_seconds(plan, 4) == pytest.approx(ticks * 0.25 / 4)


def test_a_probe_counts_the_ticks_that_it_ran():
    steps = []
    ticks, seconds = run_for(SimpleNamespace(step=lambda: steps.append(1)), 0.001)
    assert ticks == len(steps) > 0
    assert seconds >= 0.001


@pytest.mark.parametrize(("seconds", "words"), [(0.2, "0 s"), (59.0, "59 s"), (7000.0, "1.9 h")])
def test_durations_are_told_as_readers_say_them(seconds, words):
    assert format_duration(seconds) == words
