"""Environments by id, in Gymnasium and in PettingZoo, entered when the package is imported.

Nothing of the world is imported for it: entry points are text, and read by `make`.
"""

import re
from itertools import product
from typing import Any

import gymnasium

_SIZES = ("05", "10", "25", "50")
_SCENARIOS = (
    "es1", "es2", "es3", "real", "ants2008", "es1-clean", "near", "two-prey", "moving-prey",
    "two-nests", "aggregation", "mg1-square", "mg1-hexagon", "mg1-dodecagon",
    *(f"waypoints-{size}{kind}" for kind in ("", "-authors") for size in _SIZES),
)  # fmt: skip

NAMES = {
    each: re.sub("^(Es|Mg)", lambda start: start[0].upper(), each.title()) for each in _SCENARIOS
}
"""Every scenario that has an id, and its name there."""

ENVS = "swarm_forage_env.envs"

VERSIONS = (2, 1)
"""The versions that have ids, the newest first; an older one stays for a release."""


KINDS = {"": "Learner", "-Joint": "Joint", "-Tuple": "Tuple"}
"""What follows a name in an id of Gymnasium, and with what the name of the class begins."""


def register_with_gymnasium() -> None:
    """Enter each scenario as `SwarmForage/<Name>-v2`, `<Name>-Joint-v2` and `<Name>-Tuple-v2`."""
    for (scenario, name), version, (kind, cls) in product(NAMES.items(), VERSIONS, KINDS.items()):
        is_tuple = cls == "Tuple"
        vector = None if is_tuple else f"{ENVS}.gymnasium_vector:{cls}VectorEnv"
        gymnasium.register(
            f"SwarmForage/{name}{kind}-v{version}",
            f"{ENVS}.gymnasium_env:{cls}Env",
            vector_entry_point=vector,
            disable_env_checker=is_tuple,  # it warns of rewards that are a list
            kwargs={"scenario": scenario, **keywords_of(version, scenario)},
        )


def register_with_pettingzoo() -> None:
    """Enter `swarm_forage/<scenario>-v2`, in turn and in parallel, from PettingZoo 1.27 on."""
    try:
        from pettingzoo import register
    except ImportError:
        return
    for version in VERSIONS:
        for scenario in NAMES:
            kwargs = {"scenario": scenario, **keywords_of(version, scenario)}
            for kind, entry in (("aec", "env"), ("parallel", "parallel_env")):
                name = f"swarm_forage/{scenario}-v{version}"
                register(kind, name, f"{ENVS}.pettingzoo_env:{entry}", kwargs=kwargs)


def keywords_of(version: int, scenario: str) -> dict[str, Any]:
    """What a version has in front of the keywords given; nothing in the newest.

    Version 1: half the cruise speed at 0, no reflexes, and zeros for a robot without a goal.
    """
    if version > 1 or scenario.startswith("waypoints"):
        return {}
    return {"action": "drive-v1", "reflexes": False, "walk": False}
