"""How the command is started and completed: by a module, by a shell, without a package."""

import pytest

from swarm_forage_env import __main__ as module

WITHOUT = """
import runpy
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == {package!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Missing())
sys.argv = ["swarm-forage", *{arguments}]
runpy.run_module("training.cli", run_name="__main__")
"""

MISSING = {
    "typer matplotlib": (
        "evaluate", "evaluate es1 nc --episodes=1 --set=task.duration=1 --physics=kinematic"
        " --plot=x.png --workers=1",
    ),
    "pygame": ("render", "watch es1 nc --set=task.duration=1 --video=x.mp4"),
    "ray": ("ray", "evaluate es1 nc --backend=ray"),
    "cmaes": ("train", "train weighting es1"),
    "safetensors": ("evaluate", "evaluate es1 learned-weighting --episodes=1"),
    "benchmarl": ("torchrl", "benchmark ladder --algorithm=qmix --rung=near"),
}  # fmt: skip
"""Packages, the extra that brings them, and a command that needs each."""

WITHOUT_FIGURES = """
import sys
from training.cli import main

sys.argv = ["swarm-forage", "list"]
try:
    main()
finally:
    heavy = {"joblib", "matplotlib", "pandas", "pyarrow", "scipy.stats", "seaborn", "torch"}
    print(sorted(heavy & sys.modules.keys()), file=sys.stderr)
"""


def ended(run):
    """Status, stdout and stderr of a process."""
    stdout, stderr = run.communicate(timeout=120)
    return run.returncode, stdout, stderr


def test_the_package_runs_as_the_command(process):
    arguments = "list", "nc", "--format=json"
    status, stdout, stderr = ended(process(*arguments, module="swarm_forage_env"))
    assert (status, stderr) == (0, "")
    assert stdout == ended(process(*arguments))[1]


def test_a_package_that_is_not_installed_has_no_command_and_says_so(monkeypatch):
    monkeypatch.setattr(module, "entry_points", lambda **_: [])
    with pytest.raises(SystemExit, match=r"^swarm-forage: is not installed; in a checkout: pip"):
        module.main()


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("swarm-forage eval", {"evaluate"}),
        ("swarm-forage evaluate es1-", {"es1-clean"}),
        ("swarm-forage evaluate mi", {"mine.toml"}),
        ("swarm-forage evaluate es1 nc dsgif", {"dsgiff", "dsgiff-frequent", "dsgiff-penalised"}),
        ("swarm-forage list no-", {"no-error"}),
        ("swarm-forage train moti", {"motion"}),
    ],
)
def test_the_shell_completes_commands_and_names(process, tmp_path, typed, offered):
    (tmp_path / "mine.toml").write_text('base = "es1"\n')
    variables = {
        "_SWARM_FORAGE_COMPLETE": "complete_bash",
        "COMP_WORDS": typed,
        "COMP_CWORD": str(len(typed.split()) - 1),
    }
    status, stdout, stderr = ended(process(variables=variables))
    assert (status, set(stdout.split()), stderr) == (0, offered, "")


@pytest.mark.parametrize("missing", " ".join(MISSING).split())
def test_a_missing_package_is_told_in_one_line_with_its_extra(process, missing):
    extra, command = next(told for names, told in MISSING.items() if missing in names.split())
    code = WITHOUT.format(package=missing, arguments=command.split())
    status, stdout, stderr = ended(process(code=code))
    assert (status, stdout) == (1, "")
    (line,) = [line for line in stderr.splitlines() if "pip install" in line]
    assert line.startswith(f"swarm-forage: this command needs '{missing}")
    assert line.endswith(f": pip install 'swarm-forage[{extra}]'")
    assert "Traceback" not in stderr


def test_the_list_imports_nothing_that_it_does_not_need(process):
    assert ended(process(code=WITHOUT_FIGURES))[2] == "[]\n"
