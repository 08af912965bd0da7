"""The command `benchmark`: the ladder's cards and runs."""

import json

from training.ladder.rungs import read_rungs


def test_the_cards_are_listed(command):
    status, stdout, _ = command("benchmark", "list")
    assert status == 0
    assert "1 near  Near, without drift" in stdout
    assert "sb3_ppo" in stdout
    _, listed, _ = command("benchmark", "list", "--format=json")
    assert [each["name"] for each in json.loads(listed)] == list(read_rungs())


def test_a_page_is_written_without_runs(command, tmp_path):
    status, stdout, stderr = command("benchmark", "ladder", "--seeds=0", "--page=ladder.md")
    assert (status, stdout) == (0, "")
    assert "0 of 0 runs found in docs/data/ladder.parquet, 0 to make" in stderr
    assert (tmp_path / "ladder.md").read_text().startswith("# The ladder")
    assert json.loads((tmp_path / "runs/marl_eval.json").read_text()) == {"swarm_forage": {}}
