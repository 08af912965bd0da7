"""The command that shows one episode."""

import json
import re
import subprocess
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from baselines.evaluation.plot_style import style_of
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


@pytest.mark.parametrize(("name", "fps"), [("a.mp4", 30), ("a.gif", 12)])
def test_a_video_has_the_frames_of_its_time(command, tmp_path, name, fps):
    status, out, err = command(
        "watch", "es1", "nc", *SHORT, "--video", name, "--seconds", 8, "--speed", 4
    )
    assert (status, out) == (0, "")
    assert f"swarm-forage: wrote {name}" in err
    frames = decoded(tmp_path / name)
    assert len(frames) == pytest.approx(8 / 4 * fps + 1, abs=1)
    assert (frames[0] != frames[-1]).any()
    assert [file.name for file in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("limit", [0, 100, 4096, 20_000])
@pytest.mark.parametrize(
    "option", ["--video=a.mp4", "--video=a.gif", "--frame=a.png", "--html=a.html"]
)
def test_on_a_full_disk_no_half_file_is_told_as_written(
    command, tmp_path, full_disk, option, limit
):
    file = tmp_path / option.partition("=")[2]
    file.write_bytes(b"older")
    with full_disk(limit):
        status, out, err = command(
            "watch", "es1", "nc", *SHORT, "--seconds", 8, "--speed", 4, option
        )
    assert (status, out) in {(1, ""), (2, "")}
    assert f"{file.name}: cannot be written" in err
    assert "wrote" not in err
    assert err.count("\n") == 1
    assert file.read_bytes() == b"older"
    assert list(tmp_path.iterdir()) == [file]


def test_a_video_in_slow_motion_repeats_its_frames(command, tmp_path):
    assert (
        command("watch", "es1", "nc", *SHORT, "--video", "a.mp4", "--seconds", 1, "--speed", 1)[0]
        == 0
    )
    assert len(decoded(tmp_path / "a.mp4")) == 31


def test_a_still_shows_the_last_moment(command, tmp_path):
    import pygame

    made = command("watch", "es1", "ssgikf", *SHORT, "--select", 2, "--frame", "a.png")
    assert made[0] == 0
    assert pygame.image.load(tmp_path / "a.png").get_width() == 400


def test_without_a_file_a_window_opens_and_shows_the_episode(command):
    status, out, err = command("watch", "es1", "nc", *SHORT, "--speed", 256)
    assert (status, out, err) == (0, "", "")


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--video", "x.avi"], "--video x.avi: the name must end in .mp4, .gif"),
        pytest.param(
            ["--frame", "/proc/x.png"],
            "--frame /proc/x.png: cannot be written",
            marks=pytest.mark.skipif(not Path("/proc").is_dir(), reason="a folder of Linux"),
        ),
        (["--html", "x.htm"], "--html x.htm: the name must end in .html"),
        (["--select", 10], "--select=10: must be 0 to 9, a robot of es1"),
        (["--speed", 0], "speed=0: must be 0.1 to 256 times real time"),
        (["--size", 100], "size=100: must be 400 to 3840"),
        (["--start", 12], "--start=12: must be 0 to less than the 12 s"),
        (["--start", 4, "--seconds", 9], "--seconds=9: must be above 0 and at most 8 [s]"),
        (["--physics", "magic"], "no physics engine named 'magic'"),
        (["--set", "tick"], "--set 'tick': must be name=value"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_one_line(command, options, complaint):
    status, out, err = command("watch", "es1", "nc", *SHORT, *options)
    assert (status, out) == (2, "")
    assert complaint in err
    assert err.count("\n") == 1


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
    assert about["colour"] == style_of("nc").colour, "as in figures"
    assert about["beside"][0]["colour"] == style_of("ssgikf").colour
    assert 'id="recording-1"' in page
    again = about["command"].replace("two.html", "again.html").split()[1:]
    assert command(*again)[0] == 0
    same = (tmp_path / "again.html").read_text(encoding="utf-8")
    assert same == page.replace("two.html", "again.html")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("nc", "ssgikf"), "nc and ssgikf: only a replay shows two side by side; add --html FILE"),
        (("nc", "ssgikf", "--html=a.html", "--frame=a.png"), "without --video and --frame"),
        (("nc", "ssgikf", "ssgiff", "--html=a.html"), "3 controllers: at most 2 are shown"),
        (("nc", "nc", "--html=a.html"), "controller 'nc' is named twice"),
    ],
)
def test_controllers_that_cannot_be_shown_together_are_refused(command, arguments, complaint):
    status, _, err = command("watch", "es1", *arguments)
    assert status == 2
    assert complaint in err
    assert err.count("\n") == 1


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
    assert command("watch", "es1", "nc", *SHORT, "--start=6", "--speed=256")[0] == 0
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


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--drive=10"], "--drive=10: must be 0 to 9, a robot of es1"),
        (["--drive=1", "--frame=a.png"], "leave out --start, --video, --html and --frame"),
        (["--drive=1", "--start=3"], "leave out --start"),
    ],
)
def test_a_robot_that_cannot_be_driven_is_refused(command, options, complaint):
    status, _, err = command("watch", "es1", "nc", *options)
    assert status == 2
    assert complaint in err
