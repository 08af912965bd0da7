"""What the command `reproduce` does with its options, without running an episode."""

import json
from types import SimpleNamespace

import pytest
from PIL import Image

from baselines.papers import commands_reproduce, reproduction, sequential, social_odometry
from baselines.papers.claim_types import Order, number
from baselines.papers.experiments import Experiment
from baselines.papers.figures import Boxes
from baselines.papers.paper import Paper
from baselines.papers.reproduction import (
    ReproduceOptions,
    Reproduction,
    expected_seconds,
    format_duration,
)
from swarm_forage_env.errors import ConfigError


def test_the_command_line_is_that_of_the_same_episodes():
    plain = ReproduceOptions("social-odometry")
    assert plain.command == "swarm-forage reproduce social-odometry --episodes=30 --seed=0"
    other = ReproduceOptions("ants2008", 3, False, 7, "kinematic", ["task.duration=60", "tick=0.2"])
    assert other.command == (
        "swarm-forage reproduce ants2008 --set=task.duration=60 --set=tick=0.2"
        " --episodes=3 --seed=7 --physics=kinematic"
    )
    adaptive = ReproduceOptions("ants2008", adaptive=True)
    assert adaptive.command == "swarm-forage reproduce ants2008 --episodes=adaptive --seed=0"


@pytest.mark.parametrize(
    ("paper", "n"),
    [("social-odometry", 30), ("ants2008", 30), ("adaptive-boids", 100), ("boids-foraging", 30),
     ("robustness", 10), ("transfer", 10)],
)  # fmt: skip
def test_every_paper_can_be_asked_for_and_has_its_replications(paper, n):
    assert ReproduceOptions(paper).replications == n
    assert paper in commands_reproduce.PAPER_NAMES


def test_a_reproduction_is_kept_in_the_folder_that_is_asked_for(tmp_path):
    options = ReproduceOptions("social-odometry", 2, physics="kinematic")
    elsewhere = Reproduction(options, tmp_path / "x")
    assert elsewhere.folder == tmp_path / "x"
    assert list(elsewhere.plan.seeds) == [0, 1]
    assert {each.physics for each in elsewhere.plan.configurations} == {"kinematic"}
    with pytest.raises(ConfigError, match="physics"):
        Reproduction(ReproduceOptions("ants2008", physics="soft"))


NC, SSGIKF = Experiment("es1", "nc"), Experiment("es1", "ssgikf")
SHORT = "--set=task.duration=20", "--physics=kinematic", "--workers=1"


@pytest.fixture(autouse=True)
def small(monkeypatch, tmp_path):
    """In the place of the technical report, and in an empty folder."""
    claims = (number("es1: round trips, NC", NC, 60.0), Order("order", ((SSGIKF, NC),)))
    paper_figure = Boxes("tr14", "Round trips.", ("", "trips"), {"es1": {"NC": {"": NC}}})
    paper = Paper("social-odometry", claims, (paper_figure,), 30, social_odometry.LEFT_OPEN)
    monkeypatch.setattr(social_odometry, "PAPER", paper)
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def reproduce(command):
    return lambda *arguments: command("reproduce", "social-odometry", *arguments)


def test_json_is_the_claims_and_the_status_is_zero_though_they_fail(reproduce, tmp_path):
    status, stdout, stderr = reproduce("--episodes=2", "--format=json", *SHORT)
    assert status == 0
    rows = json.loads(stdout)
    assert not any(row["reproduced"] for row in rows)
    assert "swarm-forage: about " in stderr
    folder = tmp_path / "runs" / "reproduce-social-odometry"
    assert json.loads((folder / "claims.json").read_text("utf-8")) == rows
    assert (folder / "social_odometry.md").exists()
    assert (folder / "figures" / "tr14.png").exists()


def test_adaptive_episodes_decide_each_claim_on_the_page_and_as_json(
    reproduce, monkeypatch, tmp_path
):
    """What is decided so far is written after each look."""
    write, written = reproduction.Reproduction.write, []

    def watched(run, *given):
        written.append([each.n for each in run.decided])
        return write(run, *given)

    monkeypatch.setattr(reproduction.Reproduction, "write", watched)
    monkeypatch.setattr(sequential, "LOOKS", (2, 3))
    status, stdout, stderr = reproduce("--episodes=adaptive", *SHORT)
    assert written == [[], [2, 2], [2, 3]]
    assert status == 0
    assert "Of 2 claims" in stdout
    assert "4 of 4 episodes found" in stderr, "the first look needs nothing new"
    folder = tmp_path / "runs" / "reproduce-social-odometry"
    assert "## Decided by more episodes" in (folder / "social_odometry.md").read_text("utf-8")
    rows = json.loads((folder / "decisions.json").read_text("utf-8"))
    assert [row["decision"] for row in rows] == ["fails", "undecided"]
    status, _, stderr = reproduce("--episodes=some", *SHORT)
    assert (status, "'some' is neither a whole number nor adaptive" in stderr) == (2, True)


def test_what_has_been_run_is_not_run_again_and_quick_is_six_replications(reproduce):
    reproduce("--quick", "--episodes=2", *SHORT)
    status, stdout, stderr = reproduce("--quick", *SHORT)
    assert status == 0
    assert "4 of 12 episodes found" in stderr
    assert "0 of 2 claims reproduced" in stdout


def test_a_page_elsewhere_has_its_figures_for_a_paper_as_broad_as_a_column(reproduce, tmp_path):
    page, figures = tmp_path / "docs" / "page.md", tmp_path / "docs" / "figures"
    assert reproduce("--episodes=2", "--style=paper", "--page=docs/page.md", *SHORT)[0] == 0
    command_line = "swarm-forage reproduce social-odometry --set=task.duration=20 --episodes=2"
    assert command_line in page.read_text("utf-8")
    with Image.open(figures / "tr14.png") as image:
        assert image.width == 670
    assert (figures / "tr14.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("wrong", ["--episodes=0", "--workers=0", "--seed=-1", "--physics=soft"])
def test_nonsense_is_refused_in_one_line(reproduce, wrong):
    status, stdout, stderr = reproduce(wrong)
    assert (status, stdout) == (2, "")
    assert len(stderr.splitlines()) == 1


def plan(*configurations, todo):
    return SimpleNamespace(
        configurations=configurations,
        todo={each.key: range(n) for each, n in zip(configurations, todo, strict=True) if n},
    )


def test_each_scenario_is_timed_once_and_only_if_something_is_left_to_run(monkeypatch):
    few, same, many, other = (
        Experiment(*names, (f"task.n_robots={n}", f"task.duration={seconds}")).configuration(None)
        for *names, n, seconds in (
            ("es1", "nc", 5, 100), ("es1", "ssgikf", 5, 100), ("es1", "nc", 10, 100),
            ("es2", "nc", 5, 200),
        )
    )  # fmt: skip
    timed = []

    def speed(configuration):
        timed.append(configuration)
        return 0.25 * len(timed)

    monkeypatch.setattr(reproduction, "seconds_per_tick", speed)
    assert expected_seconds(plan(few, same, many, other, todo=(0, 2, 3, 1)), 2) == pytest.approx(
        (0.25 * 2 * 1000 + 0.5 * 3 * 1000 + 0.75 * 1 * 2000) / 2
    )
    assert timed == [same, many, other]
    assert expected_seconds(plan(few, same, todo=(0, 0)), 1) == 0.0


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(59.4, "59 s"), (60.0, "1 min"), (149.0, "2 min"), (3599.0, "60 min"), (3600.0, "1.0 h"),
     (5400.0, "1.5 h"), (0.0, "0 s")],
)  # fmt: skip
def test_durations_change_their_unit_at_a_minute_and_at_an_hour(seconds, words):
    assert format_duration(seconds) == words
