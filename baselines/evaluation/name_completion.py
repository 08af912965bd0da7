"""Names that the shell completes: scenarios, their files, controllers, and names of a list."""

from collections.abc import Callable, Collection, Iterator
from pathlib import Path

from swarm_forage_env.registry import CONTROLLERS, POLICIES, REFERENCES, SCENARIOS


def completion_of(names: Collection[str]) -> Callable[[str], list[str]]:
    """What completes one of these names.

    >>> completion_of(["paths", "on-path", "png"])("p")
    ['paths', 'png']
    """

    def complete(incomplete: str) -> list[str]:
        return [name for name in names if name.startswith(incomplete)]

    return complete


def scenario_names(incomplete: str) -> Iterator[str]:
    """Scenarios, and .toml files beside, that begin so."""
    yield from (name for name in SCENARIOS if name.startswith(incomplete))
    yield from (str(file) for file in Path().glob("*.toml") if str(file).startswith(incomplete))


def controller_names(incomplete: str) -> Iterator[str]:
    """Controllers and oracles that begin so, and the kinds of policies that take a file."""
    names = [*CONTROLLERS, *REFERENCES, *(f"{kind}:" for kind in POLICIES)]
    yield from (name for name in names if name.startswith(incomplete))


def any_name(incomplete: str) -> Iterator[str]:
    """Whatever can be listed: scenarios and controllers."""
    yield from scenario_names(incomplete)
    yield from controller_names(incomplete)
