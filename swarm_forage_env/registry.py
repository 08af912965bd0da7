"""Registries of parts by name. A decorator registers a part; plug-ins use entry points."""

import importlib
import inspect
import pkgutil
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from importlib.metadata import EntryPoint, entry_points
from types import FunctionType
from typing import Any, Generic, TypeVar

from swarm_forage_env.errors import RenamedWarning, UnknownNameError
from swarm_forage_env.extras import COMMON_NAMES, other_package, remedy

PartT = TypeVar("PartT")

PLUGIN_GROUP = "swarm_forage_env.controllers"
"""Entry points of this group name modules; importing one registers the parts in it."""

JOINT = "+"
"""Separator of the names in a composition."""

_left_out: dict[EntryPoint, str] = {}
"""Plug-ins that could not be imported, each with the reason."""


class Registry(Generic[PartT]):
    """Registry of the parts of one kind, by name.

    For an unknown name, the registry imports the modules that installed packages list under
    the entry-point group `swarm_forage_env.controllers`.
    """

    def __init__(self, kind: str, modules: Iterable[str] = ()) -> None:
        """Create an empty registry; `kind` is the word for a part in error messages.

        The modules register the built-in parts; they are imported at the first use of a part.
        """
        self.kind = kind
        self._modules = tuple(modules)
        self._parts: dict[str, PartT] = {}
        self._abouts: dict[str, str] = {}
        self._new_names: dict[str, str] = {}
        self._compose: Callable[[str, Sequence[str]], PartT] | None = None
        self.elements: Sequence[Registry[Any]] = ()
        """Registries of the elements of a composition, in the order of its name."""

    def register(self, name: str, about: str = "") -> Callable[[PartT], PartT]:
        """Return a decorator that registers a part; ValueError if its name is taken.

        `about` describes the part in a few words, and takes precedence over its docstring.
        """

        def enter(part: PartT) -> PartT:
            if name in self._parts:
                raise ValueError(f"two {self.kind}s are named '{name}'; rename one, or restart")
            self._parts[name] = part
            self._abouts[name] = about
            return part

        return enter

    def alias(self, old: str, new: str) -> None:
        """Keep an old name for a part; its use gives a RenamedWarning with the new name."""
        self._new_names[old] = new

    def compose_by(
        self, make: Callable[[str, Sequence[str]], PartT], elements: Sequence["Registry[Any]"]
    ) -> None:
        """Set the function that makes a part from a name such as `a+b+c` and from its elements."""
        self._compose, self.elements = make, elements

    def __getitem__(self, name: str) -> PartT:
        if not isinstance(name, str):
            raise UnknownNameError(self.kind, repr(name), self)
        for load in (self._load_built_in, load_plugins):
            if name not in self._parts:
                load()
        if name in self._parts:
            return self._parts[name]
        if name in self._new_names:
            new = self._new_names[name]
            message = f"{self.kind} '{name}' is now '{new}'; the next release removes the old name"
            warnings.warn(message, RenamedWarning, stacklevel=1)
            return self[new]
        if self._compose is not None and JOINT in name:
            return self._compose(name, [each.strip() for each in name.split(JOINT)])
        raise UnknownNameError(self.kind, name, self._parts, left_out())

    def __contains__(self, name: object) -> bool:
        if name in self._parts or name in set(self) or name in self._new_names:
            return True
        return isinstance(name, str) and self._compose is not None and JOINT in name

    def about(self, name: str) -> str:
        """Return the description of a part: that of its registration, or else the first line of the
        docstring of a class or function."""
        part = self[name]
        written = inspect.getdoc(part) if isinstance(part, type | FunctionType) else None
        return self._abouts.get(name) or (written or "").partition("\n")[0]

    def name_of(self, part: PartT) -> str | None:
        """Return the name under which a part is registered; None if it is not."""
        return next((name for name, each in self._parts.items() if each is part), None)

    def loaded(self) -> list[PartT]:
        """Return the parts registered so far, without importing plug-ins."""
        return list(self._parts.values())

    def __iter__(self) -> Iterator[str]:
        """Iterate over all names, including those of plug-ins, excluding old names."""
        self._load_built_in()
        load_plugins()
        return iter(sorted(self._parts))

    def _load_built_in(self) -> None:
        for module in self._modules:
            importlib.import_module(module)


CONTROLLERS: Registry[Any] = Registry("controller")
"""Complete controllers; this package registers none itself."""

POLICIES: Registry[Any] = Registry("kind of policy")
"""Controllers that need the file of a policy, such as `sb3` in `sb3:model.zip`."""

REFERENCES: Registry[Any] = Registry("reference")
"""Oracles, which know the ground truth: for comparison only; no environment runs them."""

TASK_MODULES = (
    "swarm_forage_env.foraging.task",
    "swarm_forage_env.waypoints.task",
    "swarm_forage_env.aggregation",
)
"""Modules of the built-in tasks."""

SCENARIOS: Registry[Any] = Registry(
    "scenario",
    (
        "swarm_forage_env.foraging.named",
        "swarm_forage_env.foraging.arenas",
        "swarm_forage_env.aggregation",
        "swarm_forage_env.waypoints.named",
    ),
)
"""Scenarios by name."""

ORIGINS: dict[str, dict[str, str]] = {}
"""Sources of the parameters that a scenario changes: scenario -> dotted name -> source."""


def load_plugins() -> None:
    """Import every module listed under the entry-point group; a second call changes nothing.

    A module that cannot be imported is skipped; `left_out` lists it with the reason. The built-in
    modules come first: of two parts of one name, that of the other package is left out.
    """
    for built_in in (*SCENARIOS._modules, *TASK_MODULES):
        importlib.import_module(built_in)
    points = entry_points(group=PLUGIN_GROUP)
    for point in sorted(points, key=lambda each: each.module.split(".")[0] not in COMMON_NAMES):
        if point in _left_out:
            continue
        try:
            point.load()
        except (Exception, SystemExit) as error:  # plug-ins may raise anything
            _left_out[point] = " ".join(_reason(error).split())


def left_out() -> str:
    """Return which plug-ins could not be imported, and why; empty if all could."""
    reasons = (f"'{each.name}' ({each.value}): {why}" for each, why in _left_out.items())
    return f"left out: plug-in {', '.join(reasons)}" if _left_out else ""


def _reason(error: BaseException) -> str:
    if not isinstance(error, ImportError):
        return f"{type(error).__name__}: {error}".removesuffix(": ")
    if namesake := other_package(error.name):
        return namesake
    if not isinstance(error, ModuleNotFoundError) or error.name is None:
        return str(error)
    install = remedy(error.name)
    return f"'{error.name}' is missing" + (f", {install}" if install else "")


def load_folder(package: str, path: Iterable[str]) -> None:
    """Import every module of a folder, so that all its parts are registered."""
    for module in pkgutil.iter_modules(path):
        importlib.import_module(f"{package}.{module.name}")
