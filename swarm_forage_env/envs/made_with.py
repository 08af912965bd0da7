"""How an environment was made, as JSON on its space of observations.

Trainers keep the spaces that they train on: stable-baselines3 writes every attribute of them as
plain JSON into what `model.save("model.zip")` makes, whichever wrapper the environment was in. So
a model can be run under the keywords of its training (`training.policy_card` reads them).
"""

import json

from gymnasium.spaces import Box

from swarm_forage_env.envs.config import PolicyKeywords
from swarm_forage_env.envs.make import EnvParts
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.interface import Controller
from swarm_forage_env.registry import CONTROLLERS

ON_SPACE = "policy_card"
"""Attribute of an observation space that holds how the environment was made."""


def made_with(parts: EnvParts, form: PolicyForm) -> str:
    """Scenario, controller, keywords of the policy and what it observes, as JSON."""
    keywords = {name: getattr(parts.config, name) for name in PolicyKeywords.model_fields}
    keywords["observation"] = "+".join(_names(parts.config.observation))
    told = {
        "format": 2,
        "scenario": parts.scenario.name,
        "controller": name_and_changes(parts.controller),
        "keywords": keywords,
        "observes": form.observes,
    }
    return json.dumps(told)


def put_on(space: Box, text: str) -> None:
    """Let a space keep how the environment was made, when it is pickled too."""
    setattr(space, ON_SPACE, text)


def _names(observation: object) -> list[str]:
    """Names of what is observed; for a class of the user's its module and name."""
    listed = observation if isinstance(observation, list | tuple) else [observation]
    return [each if isinstance(each, str) else _path(each) for each in listed]


def _path(observation: object) -> str:
    kind = observation if isinstance(observation, type) else type(observation)
    return f"{kind.__module__}:{kind.__qualname__}"


def name_and_changes(controller: Controller) -> str:
    """A controller as its name and the parameters that differ from those of that name."""
    name, own = controller.name, getattr(controller, "parameters", None)
    if name not in CONTROLLERS or own is None:
        return name
    usual = CONTROLLERS[name].parameters
    changes = [f"{k}={v}" for k, v in own.items() if usual.get(k) != v]
    return f"{name}:{','.join(changes)}" if changes else name
