"""The command `plot`: what it writes, and what it refuses in one line."""

import json
import re
from pathlib import Path

import pytest
from PIL import Image

SHORT = "--set=task.duration=20", "--physics=kinematic", "--workers=1"


@pytest.fixture
def evaluated(command):
    """A dataset of two controllers in runs/es1."""
    assert command("evaluate", "es1", "nc", "ssgikf", "--episodes=2", *SHORT)[0] == 0


@pytest.mark.usefixtures("evaluated")
def test_a_figure_is_written_in_each_format_with_the_command_in_it(command, tmp_path):
    command_line = "plot", "on-path", "runs/es1", "--controller=nc"
    status, stdout, stderr = command(*command_line, "--out=figures/x.png", "--out=figures/x.svg")
    assert (status, stdout) == (0, "")
    assert stderr.splitlines() == [
        "swarm-forage: --out figures/x.png: created the folder figures",
        "swarm-forage: wrote figures/x.png",
        "swarm-forage: wrote figures/x.svg",
    ]
    line = "swarm-forage plot on-path runs/es1 --controller nc"
    assert line in (tmp_path / "figures" / "x.svg").read_text()
    assert json.loads((tmp_path / "figures" / "x.png.json").read_text())["command"] == line


WATCH = "watch", "es1", "nc", "--set=task.duration=12", "--size=400", "--seconds=8", "--speed=4"
DRAWN = [
    *(("plot", "boxplot", "runs/es1", f"--out=x.{ending}") for ending in ("png", "pdf", "svg")),
    *((*WATCH, option) for option in ("--video=x.mp4", "--video=x.gif", "--frame=x.png")),
    (*WATCH, "--html=x.html"),
]


@pytest.mark.usefixtures("evaluated")
@pytest.mark.parametrize("limit", [100, 4096])
@pytest.mark.parametrize("arguments", DRAWN, ids=lambda each: f"{each[0]} {each[-1]}")
def test_on_a_full_disk_an_earlier_file_stays(command, tmp_path, full_disk, arguments, limit):
    file = tmp_path / arguments[-1].partition("=")[2]
    file.write_bytes(b"older")
    with full_disk(limit):
        status, stdout, stderr = command(*arguments)
    assert status in {1, 2}
    assert stdout == ""
    assert file.name in stderr
    assert "wrote" not in stderr
    assert stderr.count("\n") == 1
    assert file.read_bytes() == b"older"
    assert {each.name for each in tmp_path.iterdir()} == {file.name, "runs"}


@pytest.mark.usefixtures("evaluated")
def test_paths_say_that_they_run_an_episode(command):
    status, _, stderr = command("plot", "paths", "runs/es1", "--controller=nc", "--out=x.png")
    assert status == 0
    assert stderr.splitlines() == [
        "swarm-forage: running es1, task.duration=20, kinematic, nc, seed 0",
        "swarm-forage: wrote x.png",
    ]


@pytest.mark.usefixtures("evaluated")
def test_a_figure_for_a_paper_is_as_broad_as_a_column_and_has_its_caption_if_asked_for(
    command, tmp_path
):
    wide, captions = [], []
    for options in ((), ("--style=paper", "--caption")):
        command("plot", "boxplot", "runs/es1", *options, "--out=x.png", "--out=x.svg")
        with Image.open(tmp_path / "x.png") as image:
            wide.append(image.width / 200)
        captions.append((tmp_path / "x.svg").read_text().count("Quartile boxes"))
    assert (wide, captions) == ([8.0, 3.35], [1, 2]), "one caption is in the metadata"
    command_line = json.loads((tmp_path / "x.png.json").read_text())["command"]
    assert command_line == "swarm-forage plot boxplot runs/es1 --style paper --caption"


REFUSED = [
    (("boxplot", "runs/es1"), "Missing option '--out'"),
    (("boxplot", "--out=x.png"), "Missing argument"),
    (("box", "runs/es1", "--out=x.png"), "did you mean 'boxplot'?"),
    (("boxplot", "missing", "--out=x.png"), "dataset missing: no such folder"),
    (("boxplot", "taken", "--out=x.png"), "dataset taken: is a file; name the folder"),
    (("boxplot", "runs/es1", "--out=x.jpg"), "--out x.jpg: the name must end in .png, .pdf, .svg"),
    (("boxplot", "runs/es1", "--out=taken/x.png"), "--out taken/x.png: cannot be written"),
    (("boxplot", "runs/es1", "--out=folder.png"), "--out folder.png: cannot be written"),
    (("table", "unread", "--out=x.png", "--seed=1"), "--seed: 'table' has no such option"),
    (("boxplot", "runs/es1", "--out=x.png", "--metric=trips"), "did you mean 'round_trips'?"),
    (("boxplot", "runs/es1", "--out=x.png", "--x=beta"), "--x: 'boxplot' has no such option"),
    (("curve", "runs/es1", "--out=x.png"), "takes two values while all else is the same"),
    (("table", "runs/es1", "--out=x.png"), "no controller here names its localisation"),
    (("learning", "runs/es1", "--out=x.png"), "policy card runs/es1"),
    (("boxplot", "runs/es1", "--out=x.png", "--style=wide"), "'screen', 'paper'"),
    (("paths", "es1", "--out=x.png"), "plot paths es1 nc ssgikf"),
    (("weights", "sikf", "--out=x.png"), "its confidence is not a path"),
    (("weights", "ssgif", "--out=x.png"), "did you mean 'ssgi"),
]


@pytest.mark.usefixtures("evaluated")
def test_bad_input_gets_one_line_and_leaves_no_file(command, tmp_path):
    (tmp_path / "taken").write_text("")
    (tmp_path / "folder.png").mkdir()
    for arguments, complaint in REFUSED:
        status, stdout, stderr = command("plot", *arguments)
        assert (status, stdout) == (2, ""), arguments
        assert complaint in stderr
        assert stderr.count("\n") == 1
        assert not (tmp_path / "x.png").exists()


def test_paths_of_trajectories_run_nothing_and_the_code_of_their_page_reads_them(command):
    asked = "evaluate", "es1", "ssgikf", "--episodes=2", "--trajectories", *SHORT
    assert command(*asked)[0] == 0
    assert "2 of 2 episodes found in runs/es1, 0 to run" in command(*asked)[2]
    assert command("plot", "paths", "runs/es1", "--out=x.png")[2] == "swarm-forage: wrote x.png\n"
    page = Path(__file__).resolve().parents[2] / "docs" / "trajectories.md"
    (code,) = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    found = {}
    exec(code, found)  # the page's own
    assert found["swarm"].shape == (201, 10)
