"""The example of behaviour cloning: it clones, and its clone is a controller."""

import pytest
from typer.testing import CliRunner

from training import train_command

pytest.importorskip("torch", reason="pip install 'swarm-forage[train]'")


def test_a_clone_is_scored_beside_the_original(example, one_thread, tmp_path, capsys):
    train_command.add_commands()
    folder, out = tmp_path / "transitions", tmp_path / "clone"
    command = ["dataset", "es1", "ssgikf", "--episodes=1", "--learners=1", f"--out={folder}"]
    assert CliRunner().invoke(train_command.app, command).exit_code == 0
    found = example("behaviour_cloning").main(
        [str(folder), "ssgikf", "--steps=300", "--episodes=1", f"--out={out}"]
    )
    name = f"network:{out}/clone.safetensors,controller=ssgikf"
    assert set(found) == {"ssgikf", name, f"{name},chance=true"}
    assert found["ssgikf"] > 100.0
    assert "round trips an episode: network:" in capsys.readouterr().out
