"""The configuration of an episode: everything that determines it but the seed."""

import ast
import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.metadata import version
from inspect import getfile
from pathlib import Path
from typing import Any

import baselines.recipes
import baselines.references.recipes
import swarm_forage_env
from baselines.controller import Recipe
from baselines.evaluation import episode, waypoint_episode
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.registry import SCENARIOS
from swarm_forage_env.scenario import Part, Scenario, leaves
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints_scenario import AnyScenario, WaypointsScenario

BYSTANDERS = {"envs", "rendering"}
"""Folders of the world that no evaluated episode passes through."""

LIBRARIES = ("numba", "numpy", "pymunk")
"""What the world calculates with; another version may round differently."""

NAMED_RECIPES = baselines.recipes.RECIPES
"""The named baselines; importing their module has entered them in the registry."""

NAMED_REFERENCES = baselines.references.recipes.RECIPES
"""The references that know the ground truth, entered in a registry of their own."""


@dataclass(frozen=True)
class ExperimentConfig:
    """A scenario, a controller with its parameters, an engine, and the code they run on."""

    label: str
    """The controller as it was asked for."""

    scenario: AnyScenario
    recipe: Recipe
    physics: str = "rigid"

    @cached_property
    def key(self) -> str:
        """Hash of everything but the seed that an episode depends on."""
        parts = [f"{type(part).__module__}.{type(part).__name__}" for part in self._layers]
        text = json.dumps([self.recipe.name, parts, self.settings, self.physics, self.code])
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @cached_property
    def settings(self) -> str:
        """Every number of the scenario and of the controller, as JSON text."""
        scenario = self.scenario.model_dump()
        return _json({"scenario": scenario, "controller": self.recipe.parameters})

    @cached_property
    def overrides(self) -> str:
        """Settings that differ from the named scenario, or else the defaults, as JSON text."""
        named = self.scenario.name in set(SCENARIOS)
        plain = WaypointsScenario() if isinstance(self.scenario, WaypointsScenario) else Scenario()
        base = find_scenario(self.scenario.name) if named else plain
        return _json(_changes(leaves(base.model_dump()), leaves(self.scenario.model_dump())))

    @cached_property
    def parameters(self) -> str:
        """Parameters that differ from the controller of that name, as JSON text."""
        base = find_recipe(self.recipe.name).parameters
        return _json(_changes(base, self.recipe.parameters))

    @cached_property
    def code(self) -> str:
        """Hash of the code behind an episode, and of the libraries' versions.

        The code is that of the world, of every file beside a layer of the controller, of those
        that a layer `reads`, and of what puts the layers together and measures.
        """
        world = Path(swarm_forage_env.__file__).parent
        inside = (file.relative_to(world) for file in world.rglob("*.py"))
        files = {world / file for file in inside if BYSTANDERS.isdisjoint(file.parts)}
        for part in self._layers:
            files |= {file for home in _files(part, Part) for file in home.parent.glob("*.py")}
            files |= set(getattr(part, "reads", ()))
        files |= {*_files(self.recipe, Recipe), Path(episode.__file__)}
        files.add(Path(waypoint_episode.__file__))
        text = hashlib.sha256(" ".join(version(library) for library in LIBRARIES).encode())
        for file in sorted(files):
            text.update(f"\n{file.parent.name}/{file.name}\n".encode() + _content(file))
        return text.hexdigest()[:16]

    @property
    def _layers(self) -> list[Any]:
        return list(self.recipe.layers.values())


def find_recipe(controller: str) -> Recipe:
    """Find the recipe of `name` or `name:parameter=value,parameter=value`, references included.

    UnknownNameError for a name or parameter that stands for nothing, ConfigError for a value
    that does not fit and for a controller that is not made of layers.
    """
    recipe = find_controller(controller, references=True)
    if not isinstance(recipe, Recipe):
        raise ConfigError(f"controller '{controller}': only a Recipe of layers can be evaluated")
    return recipe


def parse_settings(texts: Iterable[str]) -> dict[str, str]:
    """Parse settings such as `radio.max_range=0.2` into names and values.

    >>> parse_settings(["radio.max_range=0.2"])
    {'radio.max_range': '0.2'}
    """
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise ConfigError(f"--set '{text}': must be name=value, as in radio.max_range=0.2")
        if name in values:
            raise ConfigError(f"--set '{text}': {name} is given twice")
        values[name] = value
    return values


def _changes(base: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, Any]:
    """The settings that differ, by dotted name, without the configuration's own name."""
    missing = object()
    return {
        name: value
        for name, value in now.items()
        if name != "name" and base.get(name, missing) != value
    }


def _json(tree: Mapping[str, Any]) -> str:
    return json.dumps(tree, sort_keys=True)


def _content(file: Path) -> bytes:
    """What an episode may depend on in a file: of Python, the code without its docstrings."""
    content = file.read_bytes()
    return _without_prose(content) if file.suffix == ".py" else content


@cache
def _without_prose(source: bytes) -> bytes:
    """A source text as its syntax tree writes it: without comments and docstrings."""
    return ast.unparse(_WithoutDocstrings().visit(ast.parse(source))).encode()


class _WithoutDocstrings(ast.NodeTransformer):
    """Removes statements that are a constant and nothing else."""

    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        """Keep a statement that does something."""
        return None if isinstance(node.value, ast.Constant) else node


def _files(thing: object, base: type) -> set[Path]:
    """The source files of an object's class and its bases, down to `base`."""
    classes = [each for each in type(thing).__mro__ if issubclass(each, base)]
    return {Path(getfile(each)) for each in classes if each is not Part}
