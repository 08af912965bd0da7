"""The command that shows one episode."""

import json
import re
import subprocess

import imageio_ffmpeg
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from baselines.evaluation.plot_style import colour_of
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.rendering.layout import Layout
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import stage_of

SHORT = ("--set", "task.duration=12", "--size", "400")


def decoded(file):
    """The frames of a video 400 px wide, an array each."""
    raw = ("-f", "rawvideo", "-fps_mode", "passthrough", "-pix_fmt", "rgb24", "-")
    program = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", str(file), *raw]
    pixels = subprocess.run(program, capture_output=True, check=True, timeout=100).stdout
    height = Layout(stage_of(find_scenario("es1"), "nc"), 400).height
    return np.frombuffer(pixels, np.uint8).reshape(-1, height, 400, 3)


@pytest.mark.parametrize(
    ("name", "fps", "seconds", "speed"),
    [("a.mp4", 30, 8, 4), ("a.gif", 12, 8, 4), ("a.mp4", 30, 1, 1)],  # the last repeats frames
)
def test_a_video_has_the_frames_of_its_time(command, tmp_path, name, fps, seconds, speed):
    timing = f"--seconds={seconds}", f"--speed={speed}"
    status, out, err = command("watch", "es1", "nc", *SHORT, f"--video={name}", *timing)
    assert (status, out) == (0, "")
    assert f"swarm-forage: wrote {name}" in err
    frames = decoded(tmp_path / name)
    assert len(frames) == pytest.approx(seconds / speed * fps + 1, abs=1)
    assert (frames[0] != frames[-1]).any()
    assert [file.name for file in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("option", ["--video=a.gif", "--frame=a.png", "--html=a.html", ""])
def test_waypoints_are_shown_everywhere(command, tmp_path, option):
    short = "--set=task.duration=12", "--speed=256", *([option] if option else [])
    assert command("watch", "waypoints-05", "boids-adaptive", *short)[0] == 0
    made = [option.partition("=")[2]] if option else []
    assert [file.name for file in tmp_path.iterdir()] == made


def test_no_display_is_told_with_the_way_out(command, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "none-such")
    status, _, err = command("watch", "es1", "nc", *SHORT)
    assert status == 2
    assert "no window: there is no display" in err
    assert "--video" in err
    assert err.count("\n") == 1


def test_no_ffmpeg_is_told_with_the_way_out(command, monkeypatch, tmp_path):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/none/ffmpeg")
    status, _, err = command("watch", "es1", "nc", *SHORT, "--video", "x.mp4")
    assert status == 2
    assert "x.mp4: no ffmpeg was found" in err
    assert "pip install 'swarm-forage[render]'" in err
    assert not list(tmp_path.iterdir())


def test_half_a_film_is_not_kept(command, monkeypatch, tmp_path):
    from baselines.evaluation import watch

    def stopped(*arguments):
        scenes = genuine(*arguments)
        yield next(scenes)
        raise KeyboardInterrupt

    genuine = watch._scenes
    monkeypatch.setattr(watch, "_scenes", stopped)
    assert command("watch", "es1", "nc", *SHORT, "--video", "x.mp4")[0] == 130
    assert not list(tmp_path.iterdir())


def test_a_replay_of_two_controllers_shows_both_and_its_whole_command(command, tmp_path):
    options = "--seed=2", "--html=two.html", "--start=2", "--seconds=8", "--select=1", "--speed=5"
    made = command("watch", "es1", "nc", "ssgikf", "--set=task.duration=12", *options)
    assert made[0] == 0
    page = (tmp_path / "two.html").read_text(encoding="utf-8")
    about = json.loads(re.search(r'id="about">(.*?)</script>', page)[1])
    assert [about["controller"], *(each["controller"] for each in about["beside"])] == [
        "nc", "ssgikf"
    ]  # fmt: skip
    assert about["command"] == (
        "swarm-forage watch es1 nc ssgikf --set=task.duration=12 --seed=2 --speed=5.0 --select=1"
        " --start=2.0 --seconds=8.0 --html=two.html"
    ).replace(".0", "")
    assert (about["start"], about["frames"]) == (2.0, 101), "from the first tick on, for trails"
    assert about["colour"] == colour_of("nc"), "as in figures"
    assert about["beside"][0]["colour"] == colour_of("ssgikf")
    assert 'id="recording-1"' in page
    again = about["command"].replace("two.html", "again.html").split()[1:]
    assert command(*again)[0] == 0
    same = (tmp_path / "again.html").read_text(encoding="utf-8")
    assert same == page.replace("two.html", "again.html")


def test_a_replay_needs_no_pygame(process, tmp_path):
    code = """
import sys
sys.modules["pygame"] = sys.modules["imageio_ffmpeg"] = None
sys.argv = ["swarm-forage", "watch", "es1", "nc", "--set=task.duration=1", "--html=x.html"]
from training.cli import main
main()
"""
    run = process(code=code)
    assert "wrote x.html" in run.communicate(timeout=60)[1]
    assert (tmp_path / "x.html").is_file()


def test_trails_of_a_window_begin_before_its_start(command, monkeypatch):
    from swarm_forage_env.rendering.trails import Trails

    times = []
    take = Trails.take
    monkeypatch.setattr(
        Trails, "take", lambda self, scene: (times.append(scene.time), take(self, scene))[1]
    )
    shown = command("watch", "es1", "nc", *SHORT, "--start=6", "--speed=256")
    assert shown == (0, "", "")
    assert (times[0], len(times)) == (0.0, 121)


def test_team_mates_of_a_driven_robot_do_as_without_it(command, monkeypatch):
    """As far as they do not meet: in the first seconds, robots stand apart."""
    from swarm_forage_env.rendering.window import Window

    seen = []

    class Noting(Window):
        def show(self, scene):
            seen.append(scene)
            super().show(scene)

    monkeypatch.setattr("swarm_forage_env.rendering.window.Window", Noting)
    options = "--drive=3", "--speed=256", "--seconds=2", "--seed=5", "--physics=kinematic"
    status, _, err = command("watch", "es1", "ssgikf", *options)
    assert status == 0
    assert err == "swarm-forage: robot 3: 0 round trips of the swarm's 0, in 2 s\n"
    assert [scene.time for scene in seen] == pytest.approx(np.arange(21) / 10)
    loop = Loop(find_scenario("es1"), find_controller("ssgikf"), [5], "kinematic")
    assert_array_equal(seen[0].pose, loop.world.robots["pose"][0])
    loop.step()
    others = np.arange(10) != 3
    assert_array_equal(seen[1].pose[others], loop.world.robots["pose"][0][others])
    moved = np.hypot(*(seen[-1].pose - seen[0].pose)[:, :2].T)
    assert moved[3] < 0.02 < moved[others].mean()
