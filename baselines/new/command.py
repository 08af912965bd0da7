"""The command `new`: a package of one's own that runs at once, from templates."""

import keyword
import re
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from shlex import quote
from string import Template
from typing import Annotated, Literal

import typer
from typer import Argument

from baselines.evaluation.common_options import FileOption
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.errors import ConfigError

Kind = Literal["task", "weighting", "sensor", "reward"]

WORDS: dict[str, tuple[str, str]] = {
    "task": ("A task of e-pucks", "swarm-forage evaluate $name gather --episodes 5"),
    "weighting": (
        "A weighting rule",
        "swarm-forage evaluate es1 ssgikf social_odometry+$name+subsumption --episodes 5",
    ),
    "sensor": (
        "A number that policies observe",
        'python -c "from $name import $title; from swarm_forage_env import parallel_env;'
        " print(parallel_env('es1', observation=['layer', $title]).observation_layout)\"",
    ),
    "reward": (
        "A reward",
        'python -c "from $name import $name; from swarm_forage_env import parallel_env;'
        " print(parallel_env('es1', reward=$name))\"",
    ),
}
"""Of each kind what it is, and a command that shows it once it is installed."""

FOUND_BY_NAME = ("task", "weighting")
"""Kinds that commands find by an entry point; the others are passed to `parallel_env`."""


def new(
    kind: Annotated[Kind, Argument(help="Kind of part.")],
    name: Annotated[str, Argument(help="Name of the package, in lower case: my_rule.")],
    out: Annotated[
        Path | None,
        FileOption(help="Folder to create, which must not exist.", show_default="<name>"),
    ] = None,
) -> None:
    """Write a small package with a task, weighting rule, sensor or reward of your own.

    It runs and passes its tests as it is: change it from there. The guides describe the rest.
    """
    _check_name(name)
    folder = out or Path(name)
    if folder.exists():
        raise ConfigError(f"--out={folder}: exists already; name another folder, or remove it")
    made = package_files(kind, name)
    for file, text in made.items():
        target = folder / file
        target.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(target, text.encode())
    typer.echo(f"wrote {folder}: {', '.join(made)}")
    typer.echo(f"test it: cd {quote(str(folder))} && python -m pytest")


def package_files(kind: Kind, name: str) -> dict[str, str]:
    """The files of a package by their names."""
    title = "".join(each.capitalize() for each in name.split("_"))
    purpose, command = WORDS[kind]
    words = {"name": name, "title": title, "kind": kind, "what": purpose}
    words["command"] = Template(command).substitute(words)
    point = f'\n[project.entry-points."swarm_forage_env.controllers"]\n{name} = "{name}"\n'
    words["entry_point"] = point if kind in FOUND_BY_NAME else ""
    made_of = {
        "pyproject.toml": "pyproject.toml",
        "README.md": "README.md",
        f"{name}.py": f"{kind}.py",
        f"test_{name}.py": f"{kind}_test.py",
    }
    folder = files("baselines.new") / "templates"
    return {
        file: Template((folder / f"{template}.txt").read_text("utf-8")).substitute(words)
        for file, template in made_of.items()
    }


def _check_name(name: str) -> None:
    """ConfigError for a name that no module can have, or that a module or part has."""
    from baselines.weighting import WEIGHTING_RULES
    from swarm_forage_env.registry import SCENARIOS
    from swarm_forage_env.task import TASKS

    if keyword.iskeyword(name):
        raise ConfigError(f"name '{name}': is a word of Python's own; choose another")
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name):
        raise ConfigError(
            f"name '{name}': must be small letters, digits and single underscores, as my_rule"
        )
    if find_spec(name) is not None:
        raise ConfigError(f"name '{name}': Python has a module of that name; choose another")
    for registry in (TASKS, SCENARIOS, WEIGHTING_RULES):
        if name in registry:
            raise ConfigError(f"name '{name}': a {registry.kind} has that name; choose another")
