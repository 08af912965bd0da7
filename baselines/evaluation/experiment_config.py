"""Configuration of an episode: everything that determines it except the seed."""

import ast
import hashlib
import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.metadata import version
from inspect import getfile
from pathlib import Path
from typing import Any
from zlib import crc32

import baselines.controllers
import baselines.oracles.controllers  # noqa: F401 both register controllers
import swarm_forage_env
from baselines import composition, running
from baselines.controller import REGISTRIES, LayeredController
from baselines.evaluation import episode
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.extras import COMMON_NAMES
from swarm_forage_env.interface import files_read_by
from swarm_forage_env.parameters import Parameters, leaves
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import SCENARIOS
from swarm_forage_env.task import task_of

NOT_HASHED = {
    "__main__.py": "a command",
    "atomic_write.py": "how files are written",
    "device_loop.py": "a GPU",
    "device_memory.py": "a GPU",
    "drawing.py": "pictures",
    "envs": "environments for learning; what a policy is shown and gives, it `reads`",
    "errors.py": "refusals",
    "extras.py": "refusals",
    "global_state.py": "what a learner's critic is shown, and what is recorded of an episode",
    "randomise.py": "environments for learning",
    "rendering": "pictures",
    "rewards.py": "rewards",
    "scene.py": "pictures",
    "swarm_forage_v1.py": "environments for learning",
    "swarm_forage_v2.py": "environments for learning",
}
"""Folders and files of the world that do not affect an evaluated episode, with their purpose."""

LONG = 60
"""Number of letters of a setting's value from which titles show its checksum."""

OURS = ("swarm_forage_env", *COMMON_NAMES)  # an episode depends on some of their folders only

LIBRARIES = ("numba", "numpy", "pymunk")
"""Libraries that compute the world; another version may round differently."""

IDENTITY = ("overrides", "parameters", "settings", "code", "configuration")
"""Columns of a dataset that identify a configuration; the last one is its key."""


@dataclass(frozen=True)
class ExperimentConfig:
    """A scenario, a controller with its parameters, an engine, and the code they run on."""

    label: str  # the controller's name as given
    scenario: Any
    controller: LayeredController
    physics: str = "rigid"

    @cached_property
    def key(self) -> str:
        """Hash of everything that determines an episode except the seed."""
        classes = map(type, self.controller.layers.values())
        parts = [f"{each.__module__}.{each.__name__}" for each in classes]
        text = json.dumps([self.controller.name, parts, self.settings, self.physics, self.code])
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @cached_property
    def settings(self) -> str:
        """All parameters of the scenario and of the controller, and its layers, as JSON text."""
        numbers = self.controller.layer_names | self.controller.parameters
        return _json({"scenario": self.scenario.model_dump(), "controller": numbers})

    @cached_property
    def overrides(self) -> str:
        """Settings that differ from the scenario of that name or the defaults, as JSON text."""
        name = self.scenario.name
        default = task_of(self.scenario).scenario.model_construct  # unchecked: it may not fit
        base = SCENARIOS[name] if name in SCENARIOS else default()
        return _json(_changes(leaves(base.model_dump()), leaves(self.scenario.model_dump())))

    @cached_property
    def parameters(self) -> str:
        """Layers and parameters that differ from the controller of that name, as JSON text."""
        return changed_parameters(self.controller)

    @property
    def identity(self) -> dict[str, str]:
        """Value of each column of `IDENTITY`."""
        texts = self.overrides, self.parameters, self.settings, self.code, self.key
        return dict(zip(IDENTITY, texts, strict=True))

    @cached_property
    def code(self) -> str:
        """Hash of the code that runs an episode, and of the versions of LIBRARIES.

        The code is the world except NOT_HASHED, the folders of the scenario's class, the engine
        and the layers, the files that these `reads`, and the modules that compose the layers and
        measure episodes. If a part is in another package, all files of that package count.
        """
        world = Path(swarm_forage_env.__file__).parent
        parts = (*self.controller.layers.values(), self.scenario)
        read = {file for part in parts for file in files_read_by(part)}
        homes = {Path(getfile(ENGINES[self.physics]))}.union(
            (each for each in read if each.suffix == ".py"),
            *(_files(each, Parameters) for each in parts),
        )
        files = set(world.rglob("*.py")).union(*map(_source_files, homes))
        files = {each for each in files if not _is_unhashed(each, world)} | read
        files |= _files(self.controller, LayeredController)
        files |= {Path(running.__file__), Path(composition.__file__), Path(episode.__file__)}
        text = hashlib.sha256(" ".join(version(library) for library in LIBRARIES).encode())
        for file in sorted(files):
            text.update(f"\n{file.parent.name}/{file.name}\n".encode() + _content(file))
        return text.hexdigest()[:16]


def find_layered_controller(controller: str) -> LayeredController:
    """Find the controller of `name` or `name:parameter=value`, references included.

    UnknownNameError for an unknown name or parameter, ConfigError for an invalid value and for a
    controller that does not consist of layers.
    """
    layered = find_controller(controller, references=True)
    if not isinstance(layered, LayeredController):
        raise ConfigError(f"controller '{controller}': must be made of layers to be evaluated")
    return layered


def changed_parameters(controller: LayeredController) -> str:
    """Return layers and parameters that differ from the controller of that name, as JSON text."""
    base = find_layered_controller(controller.name)
    layers = _changes(base.layer_names, controller.layer_names)
    same = {layer: name for layer, name in layers.items() if name in REGISTRIES.get(layer, ())}
    numbers = base.with_parameters(same).parameters
    for added in controller.layers.keys() - base.layers.keys():
        defaults = type(controller.layers[added]).model_construct()
        numbers |= leaves({added: defaults.model_dump()})
    return _json(layers | _changes(numbers, controller.parameters))


def short_label(controller: str, parameters: str, without: str | None = None) -> str:
    """Return a controller's name with its changed parameters (a JSON text), except `without`.

    >>> short_label("ssgiff", '{"estimator.pause": 4.0, "weighting.beta": 0.001}')
    'ssgiff:pause=4,beta=0.001'
    """
    changed = ",".join(changed_settings(parameters, without, short=True))
    return f"{controller}:{changed}" if changed else controller


def changed_settings(text: str, without: str | None = None, short: bool = False) -> list[str]:
    """Return changed settings (a JSON text) as a user writes them: `beta=0.01`."""
    return [
        f"{name.rpartition('.')[2] if short else name}={_number(value)}"
        for name, value in json.loads(text).items()
        if name != without
    ]


def shortened(setting: str) -> str:
    """Return `name=value`, or with a checksum in place of a long value, such as obstacles.

    >>> shortened(f"obstacles={[{'points': [[0.0, 0.5], [0.0, 0.1]], 'radius': 0.0}] * 2}")
    'obstacles=#708d2165'
    """
    name, _, value = setting.partition("=")
    return setting if len(value) < LONG else f"{name}=#{crc32(value.encode()):08x}"


def parse_settings(texts: Iterable[str]) -> dict[str, str]:
    """Parse settings such as `radio.max_range=0.2` into names and values."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise ConfigError(f"--set '{text}': must be name=value, as in radio.max_range=0.2")
        if name in values:
            raise ConfigError(f"--set '{text}': {name} is given twice")
        values[name] = value
    return values


def _changes(base: Mapping[str, object], now: Mapping[str, object]) -> dict[str, object]:
    """Return the settings that differ by dotted name, except `name`."""
    return {k: v for k, v in now.items() if k != "name" and base.get(k, object()) != v}


def _number(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _json(tree: Mapping[str, object]) -> str:
    return json.dumps(tree, sort_keys=True)


def _is_unhashed(file: Path, world: Path) -> bool:
    inside = file.relative_to(world).parts if file.is_relative_to(world) else ()
    return not NOT_HASHED.keys().isdisjoint(inside)


def _source_files(home: Path) -> Iterable[Path]:
    """Return the Python files of a file's folder, or of its whole package if it is not in OURS."""
    folder = home.parent
    while (folder.parent / "__init__.py").is_file():
        folder = folder.parent
    is_other = (folder / "__init__.py").is_file() and folder.name not in OURS
    return folder.rglob("*.py") if is_other else home.parent.glob("*.py")


def _content(file: Path) -> bytes:
    """Return what an episode may depend on in a file; of Python files, the code without prose."""
    content = file.read_bytes()
    with suppress(SyntaxError, ValueError):  # a code template, which is not imported
        return _without_prose(content) if file.suffix == ".py" else content
    return content


@cache
def _without_prose(source: bytes) -> bytes:
    """Return a source text without comments and docstrings, as `ast.unparse` formats it."""
    return ast.unparse(_WithoutDocstrings().visit(ast.parse(source))).encode()


class _WithoutDocstrings(ast.NodeTransformer):
    """Transformer that removes statements that consist of a constant."""

    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        """Return the statement, or None if it is a constant."""
        return None if isinstance(node.value, ast.Constant) else node


def _files(thing: object, base: type) -> set[Path]:
    classes = [each for each in type(thing).__mro__ if issubclass(each, base)]
    return {Path(getfile(each)) for each in classes if each is not Parameters}
