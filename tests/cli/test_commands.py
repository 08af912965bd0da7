"""What the commands print and leave behind."""

import csv
import io
import json
import os
import shutil
import signal
import sys
import time

import pyarrow.parquet as pq
import pytest

from baselines.evaluation import runner
from baselines.evaluation.commands import FIGURE_NAMES
from baselines.papers.commands_reproduce import PAPER_NAMES
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import CONTROLLERS, POLICIES, REFERENCES, SCENARIOS

SHORT = "--set=task.duration=20", "--physics=kinematic", "--workers=1"


def test_help_is_shown_without_a_command(command):
    status, stdout, stderr = command()
    assert (status, stderr) == (0, "")
    for name in ("list", "evaluate", "plot", "reproduce", "watch", "bench"):
        assert name in stdout


@pytest.mark.parametrize("name", ["list", "evaluate", "plot", "reproduce", "watch", "bench"])
def test_every_command_explains_itself(command, name):
    status, stdout, _ = command(name, "--help")
    assert status == 0
    assert command(name, "-h")[:2] == (0, stdout)
    assert "Usage" in stdout
    assert max(map(len, stdout.splitlines())) <= 80


@pytest.mark.parametrize(("name", "names"), [("plot", FIGURE_NAMES), ("reproduce", PAPER_NAMES)])
def test_help_breaks_no_name_of_a_figure_or_paper(command, name, names):
    _, stdout, _ = command(name, "--help")
    assert set(names) <= {each.strip(":|,<>") for each in stdout.split()}


def test_a_figure_or_paper_that_there_is_not_is_told_the_nearest(command, tmp_path):
    _, _, stderr = command("plot", "boxplt", "runs/es1", "--out=figures/x.png")
    assert "no kind of figure named 'boxplt', did you mean 'boxplot'?" in stderr
    _, _, stderr = command("reproduce", "ants2009")
    assert "no paper named 'ants2009', did you mean 'ants2008'?" in stderr
    assert not list(tmp_path.iterdir())


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
        "scenario", "controller", "seed", "round_trips", "recruitment_time_s", "on_path_share",
        "lost_events", "messages", "localisation_error_m", "n_robots", "duration_s", "physics",
        "wall_s", "sound_robots", "round_trips_sound", "on_path_share_sound", "lost_events_sound",
        "localisation_error_sound_m",
    } == set(episodes[0])  # fmt: skip
    assert episodes[0]["sound_robots"] is None, "nobody is faulty"
    assert len(stderr.splitlines()) == 2, "one line at the start and one at the end"


def test_an_old_name_of_a_controller_gets_one_line_with_the_new_one(command):
    status, stdout, stderr = command(
        "evaluate", "es1", "dsgiff-wary", "--episodes=1", "--format=json", *SHORT
    )
    assert status == 0
    assert json.loads(stdout)[0]["controller"] == "dsgiff-wary"
    told = [line for line in stderr.splitlines() if "is now 'dsgiff-penalised'" in line]
    assert len(told) == 1
    assert told[0].startswith("swarm-forage: controller 'dsgiff-wary' is now")
    assert len(stderr.splitlines()) == 3


def test_threads_change_no_number(command):
    told = "evaluate", "es1", "ssgikf", "--episodes=4", "--format=json", *SHORT
    one = json.loads(command(*told, "--out=one")[1])
    two = json.loads(command(*told, "--out=two", "--threads=2")[1])
    assert [each | {"wall_s": 0} for each in one] == [each | {"wall_s": 0} for each in two]


def test_a_folder_that_is_deleted_in_mid_run_is_told_with_its_files(command, tmp_path, monkeypatch):
    run, jobs = runner._run_block, []

    def delete_before_the_last(job, threads, is_recorded, stores):
        jobs.append(job)
        if len(jobs) == 2:
            shutil.rmtree(stores[0].folder)
        return run(job, threads, is_recorded, stores)

    monkeypatch.setattr(runner, "_run_block", delete_before_the_last)
    told = "evaluate", "es1", "nc", "ssgikf", "--episodes=2", "--format=json", *SHORT
    status, stdout, stderr = command(*told)
    assert status == 1
    assert len(json.loads(stdout)) == 4, "the run goes on to its end"
    last = stderr.splitlines()[-1]
    assert "runs/es1: 2 of 4 episodes are not there any more: scenario=es1/controller=nc/" in last
    assert last.count(".parquet") == 2
    assert len(pq.read_table(tmp_path / "runs" / "es1")) == 2
    status, again, _ = command(*told)
    assert status == 0
    without = [[each | {"wall_s": 0} for each in json.loads(text)] for text in (stdout, again)]
    assert without[0] == without[1]


def test_csv_holds_the_same_episodes_and_they_are_not_run_again(command):
    told = "evaluate", "es1", "nc", "--episodes=2", *SHORT
    episodes = json.loads(command(*told, "--format=json")[1])
    status, stdout, stderr = command(*told, "--format=csv")
    lines = list(csv.DictReader(io.StringIO(stdout)))
    assert status == 0
    assert "2 of 2 episodes found in runs/es1, 0 to run" in stderr
    assert [float(line["wall_s"]) for line in lines] == [each["wall_s"] for each in episodes]


def test_the_table_compares_with_the_first_controller_and_the_plot_is_drawn(command, tmp_path):
    status, stdout, stderr = command(
        "evaluate", "es1", "nc", "ssgikf", "--episodes=3", "--plot=figures/trips.svg", *SHORT
    )
    assert status == 0
    made = "swarm-forage: --plot figures/trips.svg: made the folder figures\n"
    assert stderr.count(made) == 1
    _, _, stderr = command(
        "evaluate", "es1", "nc", "ssgikf", "--episodes=3", "--plot=figures/trips.svg", *SHORT
    )
    assert "made the folder" not in stderr, "it is there"
    assert "Round trips against nc" in stdout
    assert max(map(len, stdout.splitlines())) <= 80
    figure = (tmp_path / "figures" / "trips.svg").read_text()
    assert "swarm-forage evaluate es1 nc ssgikf --set=task.duration=20 --episodes=3" in figure


def test_one_episode_is_enough(command):
    status, stdout, _ = command("evaluate", "es1", "nc", "ssgikf", "--episodes=1", *SHORT)
    assert status == 0
    assert "n/a" in stdout
    assert "nan" not in stdout.lower()


def test_a_scenario_file_is_evaluated_under_its_name(command, tmp_path):
    (tmp_path / "mine.toml").write_text('base = "es1"\n[task]\nn_robots = 4\n')
    _, stdout, _ = command("evaluate", "mine.toml", "nc", "--episodes=1", "--format=json", *SHORT)
    (episode,) = json.loads(stdout)
    assert (episode["scenario"], episode["n_robots"]) == ("mine", 4)


def test_a_plot_inside_the_dataset_is_drawn_with_a_hint(command):
    status, _, stderr = command(
        "evaluate", "es1", "nc", "--episodes=1", "--out=out", "--plot=out/trips.png", *SHORT
    )
    assert status == 0
    assert "--plot lies inside --out" in stderr


def test_list_tells_names_and_numbers(command):
    _, stdout, _ = command("list")
    assert {"es1", "es3", "ssgikf", "dsgiff", "rigid", "kinematic"} <= set(stdout.split())
    _, stdout, _ = command("list", "ssgiff")
    assert "weighting.beta" in stdout
    assert "rad" in stdout, "a unit"
    _, stdout, _ = command("list", "es1", "--format=json")
    assert json.loads(stdout)["name"] == "es1"
    _, stdout, _ = command("list", "--format=json")
    assert set(json.loads(stdout)) == {
        "scenarios", "controllers", "references", "engines", "policies"
    }  # fmt: skip


def test_list_says_what_each_name_is_in_80_columns_and_breaks_no_name(command):
    _, stdout, _ = command("list")
    assert max(map(len, stdout.splitlines())) <= 80
    first = {line.partition(" ")[0] for line in stdout.splitlines()}
    names = {
        *SCENARIOS,
        *CONTROLLERS,
        *REFERENCES,
        *ENGINES,
        *(f"{kind}:FILE" for kind in POLICIES),
    }
    assert names <= first
    for registry in (SCENARIOS, CONTROLLERS, REFERENCES, ENGINES, POLICIES):
        told = {name: registry.about(name) for name in registry}
        assert all(len(about.split()) > 2 for about in told.values()), told
        assert len(set(told.values())) >= len(told) - 6, "the waypoints differ in their size alone"


def test_a_reader_that_stops_reading_ends_the_command_in_silence(process):
    reader, writer = os.pipe()
    run = process("list", "es1", stdout=writer)
    os.close(writer)
    os.close(reader)
    _, stderr = run.communicate(timeout=60)
    assert run.returncode == 1
    assert stderr == ""


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_ends_with_one_line_and_the_run_can_go_on(process, interruptible, workers):
    """To the whole group, as a terminal does."""
    _, stderr, status = stopped(process, workers, lambda run: os.killpg(run.pid, signal.SIGINT))
    assert status == 130
    assert stderr == "swarm-forage: stopped; the same command goes on from here\n"


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_a_run_that_is_terminated_takes_its_workers_along(process):
    """To the command alone, as a scheduler does."""
    run, stderr, status = stopped(process, 2, lambda run: run.terminate())
    assert status == 130
    assert stderr == "swarm-forage: stopped; the same command goes on from here\n"
    assert is_gone(run.pid)


def is_gone(group):
    """Whether nobody of a process group is left, in ten seconds at most."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


def stopped(process, workers, stop):
    """A run that is stopped after two seconds, what it said then, and its status."""
    run = process(
        "evaluate", "es1", "nc", "--episodes=8", "--set=task.duration=7200", f"--workers={workers}",
        start_new_session=True,
    )  # fmt: skip
    assert "8 to run" in run.stderr.readline()
    time.sleep(2.0)
    stop(run)  # `start_new_session`: its group is its own
    _, stderr = run.communicate(timeout=60)
    return run, stderr, run.returncode
