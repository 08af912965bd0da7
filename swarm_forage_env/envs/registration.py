"""Registration of environment ids with Gymnasium and PettingZoo, when the package is imported.

It imports no environment: entry points are strings, which `make` resolves.
"""

import re
from itertools import product
from typing import Any

import gymnasium

from swarm_forage_env.errors import ConfigError

_SIZES = ("05", "10", "25", "50")
_SCENARIOS = (
    "es1", "es2", "es3", "real", "ants2008", "es1-clean", "near", "two-prey", "moving-prey",
    "two-nests", "aggregation", "mg1-square", "mg1-hexagon", "mg1-dodecagon",
    *(f"waypoints-{size}{kind}" for kind in ("", "-authors") for size in _SIZES),
)  # fmt: skip

NAMES = {
    each: re.sub("^(Es|Mg)", lambda start: start[0].upper(), each.title()) for each in _SCENARIOS
}
"""Name of each scenario in Gymnasium's ids."""

ENVS = "swarm_forage_env.envs"

VERSIONS = (2, 1)
"""Versions that have ids, the newest first; an older version is kept for one release."""


KINDS = {"": "Learner", "-Joint": "Joint", "-Tuple": "Tuple", "-Shared": "Shared"}
"""Suffix of the name in Gymnasium's ids, and prefix of the class of the environment."""


def register_with_gymnasium() -> None:
    """Register each scenario as `SwarmForage/<Name><kind>-v2`, with each of `KINDS`.

    Gymnasium's vector environments take no lists of rewards; robots that share a policy are
    environments of a vector.
    """
    for (scenario, name), version, (kind, cls) in product(NAMES.items(), VERSIONS, KINDS.items()):
        is_tuple = cls == "Tuple"
        single = "registration:refuse_single" if cls == "Shared" else f"gymnasium_env:{cls}Env"
        vector = None if is_tuple else f"{ENVS}.gymnasium_vector:{cls}VectorEnv"
        gymnasium.register(
            f"SwarmForage/{name}{kind}-v{version}",
            f"{ENVS}.{single}",
            vector_entry_point=vector,
            disable_env_checker=is_tuple,  # it warns about rewards in a list
            kwargs={"scenario": scenario, **keywords_of(version, scenario)},
        )


def refuse_single(**_: object) -> gymnasium.Env[Any, Any]:
    """Raise ConfigError: the entry point for one environment of ids that have vectors only."""
    raise ConfigError(
        "gym.make: the robots of a -Shared environment are environments of one vector; use"
        " gym.make_vec, or the id without -Shared, in which one robot learns"
    )


def register_with_pettingzoo() -> None:
    """Register `swarm_forage/<scenario>-v2` as AEC and parallel API, with PettingZoo >= 1.27."""
    try:
        from pettingzoo import register
    except ImportError:
        return
    for version, scenario in product(VERSIONS, NAMES):
        kwargs = {"scenario": scenario, **keywords_of(version, scenario)}
        for kind, entry in (("aec", "env"), ("parallel", "parallel_env")):
            name = f"swarm_forage/{scenario}-v{version}"
            register(kind, name, f"{ENVS}.pettingzoo_env:{entry}", kwargs=kwargs)


def keywords_of(version: int, scenario: str) -> dict[str, Any]:
    """Return the default keywords of a version; the newest has none.

    Version 1: speed 0 is half the cruise speed, no reflexes, and zeros for a robot without a goal.
    """
    if version > 1 or scenario.startswith("waypoints"):
        return {}
    return {"action": "drive-v1", "reflexes": False, "walk": False}
