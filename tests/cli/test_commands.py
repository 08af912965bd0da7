"""What the commands print and leave behind."""

import csv
import io
import json
import os
import shutil

import pyarrow.parquet as pq
import pytest

from baselines.evaluation import runner
from baselines.evaluation.commands import FIGURE_NAMES
from baselines.papers.commands_reproduce import PAPER_NAMES
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import CONTROLLERS, POLICIES, REFERENCES, SCENARIOS

COMMANDS = (
    "list", "evaluate", "plot", "reproduce", "export", "watch", "bench", "train", "dataset", "new",
    "benchmark",
)  # fmt: skip
SHORT = "--set=task.duration=20", "--physics=kinematic", "--workers=1"


def test_help_is_shown_without_a_command(command):
    status, stdout, stderr = command()
    assert (status, stderr) == (0, "")
    for name in COMMANDS:
        assert name in stdout


@pytest.mark.parametrize(
    "name", [*COMMANDS, "benchmark list", "benchmark cards", "benchmark ladder"]
)
def test_every_command_explains_itself(command, name):
    status, stdout, stderr = command(*name.split(), "--help")
    assert (status, stderr) == (0, "")
    assert command(*name.split(), "-h")[:2] == (0, stdout)
    assert "Usage" in stdout
    assert not {"<int", "<str>", "<bool>", "<Path>", "<list[str]>"} & set(stdout.split())
    assert max(map(len, stdout.splitlines())) <= 80


@pytest.mark.parametrize(("name", "names"), [("plot", FIGURE_NAMES), ("reproduce", PAPER_NAMES)])
def test_help_breaks_no_name_of_a_figure_or_paper(command, name, names):
    _, stdout, _ = command(name, "--help")
    assert set(names) <= {each.strip(":|,<>") for each in stdout.split()}


def test_the_version_is_told(command):
    status, stdout, _ = command("--version")
    assert status == 0
    assert len(stdout.split()) in (1, 2)


def test_json_is_all_that_goes_to_stdout(command):
    status, stdout, stderr = command(
        "evaluate", "es1", "nc", "ssgiff:beta=0.02", "--episodes=2", "--seed=5", "--format=json",
        *SHORT,
    )  # fmt: skip
    assert status == 0
    episodes = json.loads(stdout)
    assert [(each["controller"], each["seed"]) for each in episodes] == [
        ("nc", 5), ("nc", 6), ("ssgiff:beta=0.02", 5), ("ssgiff:beta=0.02", 6),
    ]  # fmt: skip
    assert {
        "scenario", "overrides", "controller", "seed", "round_trips", "recruitment_time_s",
        "on_path_share", "lost_events", "messages", "localisation_error_m", "n_robots",
        "duration_s", "physics", "wall_s", "sound_robots", "round_trips_sound",
        "on_path_share_sound", "lost_events_sound", "localisation_error_sound_m",
    } == set(episodes[0])  # fmt: skip
    assert episodes[0]["sound_robots"] is None, "nobody is faulty"
    assert len(stderr.splitlines()) == 2, "one line at the start and one at the end"


def test_a_folder_that_is_deleted_in_mid_run_is_told_with_its_files(command, tmp_path, monkeypatch):
    run, jobs = runner._run_block, []

    def delete_before_the_last(job, **options):
        jobs.append(job)
        if len(jobs) == 2:
            shutil.rmtree(tmp_path / "runs" / "es1")
        return run(job, **options)

    monkeypatch.setattr(runner, "_run_block", delete_before_the_last)
    arguments = "evaluate", "es1", "nc", "ssgikf", "--episodes=2", "--format=json", *SHORT
    status, stdout, stderr = command(*arguments)
    assert status == 1
    assert len(json.loads(stdout)) == 4, "the run goes on to its end"
    last = stderr.splitlines()[-1]
    assert "runs/es1: 2 of 4 episodes no longer exist: scenario=es1/controller=nc/" in last
    assert last.count(".parquet") == 2
    assert len(pq.read_table(tmp_path / "runs" / "es1")) == 2
    status, again, _ = command(*arguments)
    assert status == 0
    without = [[each | {"wall_s": 0} for each in json.loads(text)] for text in (stdout, again)]
    assert without[0] == without[1]


def test_csv_holds_the_same_episodes_and_they_are_not_run_again(command):
    arguments = "evaluate", "es1", "nc", "--episodes=2", *SHORT
    episodes = json.loads(command(*arguments, "--format=json")[1])
    status, stdout, stderr = command(*arguments, "--format=csv")
    lines = list(csv.DictReader(io.StringIO(stdout)))
    assert status == 0
    assert "2 of 2 episodes found in runs/es1, 0 to run" in stderr
    assert [float(line["wall_s"]) for line in lines] == [each["wall_s"] for each in episodes]


def test_the_table_compares_with_the_first_controller_and_the_plot_is_drawn(command, tmp_path):
    words = "evaluate", "es1", "nc", "ssgikf", "--episodes=3", "--plot=figures/trips.svg", *SHORT
    status, stdout, stderr = command(*words)
    assert status == 0
    made = "swarm-forage: --plot figures/trips.svg: created the folder figures\n"
    assert stderr.count(made) == 1
    _, _, stderr = command(*words)
    assert "created the folder" not in stderr, "it is there"
    assert "Round trips against nc" in stdout
    assert max(map(len, stdout.splitlines())) <= 80
    figure = (tmp_path / "figures" / "trips.svg").read_text()
    assert "swarm-forage evaluate es1 nc ssgikf --set=task.duration=20 --episodes=3" in figure


def test_a_plot_inside_the_dataset_is_drawn_with_a_hint(command):
    status, _, stderr = command(
        "evaluate", "es1", "nc", "--episodes=1", "--out=out", "--plot=out/trips.png", *SHORT
    )
    assert status == 0
    assert "--plot lies inside --out" in stderr


def test_list_says_what_each_name_is_in_80_columns_and_breaks_no_name(command):
    _, stdout, _ = command("list", "es1", "--format=json")
    assert json.loads(stdout)["name"] == "es1"
    kinds = {"scenarios", "controllers", "references", "layers", "engines", "policies"}
    assert set(json.loads(command("list", "--format=json")[1])) == kinds
    _, stdout, _ = command("list")
    assert max(map(len, stdout.splitlines())) <= 80
    first = {line.partition(" ")[0] for line in stdout.splitlines()}
    policies = {f"{kind}:FILE" for kind in POLICIES}
    assert policies.union(SCENARIOS, CONTROLLERS, REFERENCES, ENGINES) <= first
    for registry in (SCENARIOS, CONTROLLERS, REFERENCES, ENGINES, POLICIES):
        texts = {name: registry.about(name) for name in registry}
        assert all(len(about.split()) > 2 for about in texts.values()), texts
        assert len(set(texts.values())) >= len(texts) - 6, "the waypoints differ in size alone"


def test_a_reader_that_stops_reading_ends_the_command_in_silence(process):
    reader, writer = os.pipe()
    run = process("list", "es1", stdout=writer)
    os.close(writer)
    os.close(reader)
    _, stderr = run.communicate(timeout=60)
    assert run.returncode == 1
    assert stderr == ""
