"""Environments by id, in Gymnasium and in PettingZoo, entered when the package is imported.

Nothing of the world is imported for it: entry points are text, and read by `make`.
"""

import gymnasium

NAMES = {
    "es1": "ES1",
    "es2": "ES2",
    "es3": "ES3",
    "real": "Real",
    "ants2008": "Ants2008",
    **{f"waypoints-{size}": f"Waypoints-{size}" for size in ("05", "10", "25", "50")},
    **{
        f"waypoints-{size}-authors": f"Waypoints-{size}-Authors"
        for size in ("05", "10", "25", "50")
    },
}
"""Every scenario that has an id, and its name there."""

ENVS = "swarm_forage_env.envs"


def register_with_gymnasium() -> None:
    """Enter for each scenario `SwarmForage/<Name>-v0`, `<Name>-Joint-v0`, `<Name>-Tuple-v0`."""
    for scenario, name in NAMES.items():
        kwargs = {"scenario": scenario}
        gymnasium.register(
            f"SwarmForage/{name}-v0",
            f"{ENVS}.gymnasium_env:LearnerEnv",
            vector_entry_point=f"{ENVS}.gymnasium_vector:LearnerVectorEnv",
            kwargs=kwargs,
        )
        gymnasium.register(
            f"SwarmForage/{name}-Joint-v0",
            f"{ENVS}.gymnasium_env:JointEnv",
            vector_entry_point=f"{ENVS}.gymnasium_vector:JointVectorEnv",
            kwargs=kwargs,
        )
        gymnasium.register(
            f"SwarmForage/{name}-Tuple-v0",
            f"{ENVS}.gymnasium_env:TupleEnv",
            disable_env_checker=True,  # it warns of rewards that are a list
            kwargs=kwargs,
        )


def register_with_pettingzoo() -> None:
    """Enter `swarm_forage/<scenario>-v0`, in turn and in parallel, where PettingZoo has a registry.

    It has one from version 1.27 on.
    """
    try:
        from pettingzoo import register
    except ImportError:
        return
    for scenario in NAMES:
        kwargs = {"scenario": scenario}
        for kind, entry in (("aec", "env"), ("parallel", "parallel_env")):
            register(
                kind, f"swarm_forage/{scenario}-v0", f"{ENVS}.pettingzoo_env:{entry}", kwargs=kwargs
            )
