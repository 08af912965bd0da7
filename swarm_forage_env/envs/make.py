"""Checks of keywords, the parts of an environment, and the record of how it was made.

The record is JSON on the observation space. Trainers save the spaces that they train on, as
stable-baselines3 does in `model.save("model.zip")`, through all wrappers: a saved model can be run
under the keywords of its training (`training.policy_card`).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from swarm_forage_env.controllers import Controllers, find_controllers
from swarm_forage_env.envs.config import EnvConfig, PolicyKeywords, chosen_robots
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.envs.rewards import REWARDS
from swarm_forage_env.errors import ConfigError, UnknownNameError, shown
from swarm_forage_env.interface import Controller, has_talk
from swarm_forage_env.mixed import MixedController, members_of
from swarm_forage_env.parameters import BaseScenario, leaves, override, resolve, validated
from swarm_forage_env.randomise import Randomisation
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import ScenarioSource, find_scenario
from swarm_forage_env.task import Task, task_of


@dataclass(frozen=True)
class EnvParts:
    """Parts of an environment."""

    form: PolicyForm
    """Scenario, keywords, and the observation and action of a policy."""
    controller: Controller
    randomisation: Randomisation


def checked_parts(
    scenario: ScenarioSource, controller: Controllers | None, options: Mapping[str, object]
) -> EnvParts:
    """Return the parts of an environment with these keywords of `parallel_env`.

    `options` are fields of `EnvConfig` and overrides of scenario parameters. Raises
    UnknownNameError or ConfigError for invalid keywords.
    """
    fields = {name: options[name] for name in EnvConfig.model_fields if name in options}
    config = validated(EnvConfig, fields)
    overrides = {name: value for name, value in options.items() if name not in fields}
    chosen = _overridden(scenario, overrides)
    controllers = find_controllers(controller, chosen)
    _check_keywords(config, task_of(chosen))
    randomisation = Randomisation(chosen, config.randomise)
    form = PolicyForm(randomisation.extremes, config)
    most, why = 0.0, f"the task {form.task.name} has no potential"
    if form.task.potential is not None:
        most, why = form.task.potential.max_shaping(chosen)
    if config.shaping > most:
        raise ConfigError(f"shaping={config.shaping:g}: {why}; must be at most {most:g}")
    learners = chosen_robots(config.learners, form.agents)
    if config.learn == "everything":
        controllers = _beside_everything(controllers, controller is not None, form, learners)
    else:
        _check_leaves_a_layer(controllers, form, learners)
    controllers.check_supports(chosen)
    if config.learn == "weighting" and not has_talk(controllers):
        why = "its robots exchange nothing that could be weighted; choose one whose robots do"
        _refuse(controllers, why)
    return EnvParts(form, controllers, randomisation)


def _check_keywords(config: EnvConfig, task: Task) -> None:
    """Raise ConfigError or UnknownNameError for unknown or conflicting keywords."""
    if isinstance(config.reward, str) and config.reward not in REWARDS:
        raise UnknownNameError("reward", config.reward, REWARDS)
    if config.residual and not task.residuals:
        raise ConfigError(f"residual=True: is not available in the task {task.name}; leave it out")
    if config.residual and config.learn not in task.residuals:
        raise UnknownNameError("layer to learn as a residual", config.learn, task.residuals)
    if config.step_on == "exchange" and not isinstance(config.reward, str):
        raise ConfigError("step_on='exchange': needs reward='own' or 'team'")


def _beside_everything(
    controller: Controller, is_given: bool, form: PolicyForm, learners: Sequence[int]
) -> Controller:
    """Return the controller of a swarm where learners replace `controller` entirely."""
    policy, n_robots = form.task.raw_control, len(form.agents)
    assert policy is not None
    if len(learners) < n_robots:
        others = members_of(controller, n_robots)
        members = (policy if k in learners else own for k, own in enumerate(others))
        return MixedController(tuple(members))
    if is_given:
        _refuse(
            controller,
            "has no robot to run if learn='everything' and all robots learn; leave it out, name"
            " the `learners`, or use learn='motion'",
        )
    return policy


def _check_leaves_a_layer(
    controller: Controller, form: PolicyForm, learners: Sequence[int]
) -> None:
    members = members_of(controller, len(form.agents))
    for robot in learners:
        if getattr(members[robot], "is_everything", False):
            _refuse(
                members[robot],
                f"replaces every layer, so that none is left for robot {robot} to learn; give it"
                " to robots that do not learn, by `learners`, or use a policy of the motion",
            )


def refuse_keywords_of_blocks(options: Mapping[str, object]) -> None:
    """Raise ConfigError for keywords of the APIs that run blocks of worlds."""
    for name in (each for each in ("n_worlds", "device") if each in options):
        raise ConfigError(
            f"{name}={shown(options[name])}: is for ArrayEnv, SwarmVecEnv and SwarmTorchEnv; leave"
            " it out, or use one of them"
        )


def _overridden(scenario: ScenarioSource, overrides: Mapping[str, object]) -> BaseScenario:
    """Return the scenario with overrides; UnknownNameError for an unknown keyword or parameter."""
    if "render_mode" in overrides:
        raise ConfigError(
            f"render_mode={shown(overrides['render_mode'])}: this interface has no render mode;"
            " use parallel_env, gymnasium.make or SwarmVecEnv, or call render() of SwarmTorchEnv"
        )
    chosen: BaseScenario = find_scenario(scenario)
    keywords = (*EnvConfig.model_fields, "controller", "render_mode")
    known = {**leaves(chosen.model_dump()), **dict.fromkeys(keywords)}
    for name in overrides:
        resolve(name, known, "keyword or scenario parameter")
    return override(chosen, overrides, "scenario parameter")


def _refuse(controller: Controller, why: str) -> NoReturn:
    raise ConfigError(f"controller '{controller.name}': {why}")


ON_SPACE = "policy_card"
"""Attribute of an observation space that holds the record of how the environment was made."""

WITH_ARGUMENTS = "(...)"
"""Suffix of the class of an observation that was given as an instance with arguments."""


def made_with(form: PolicyForm, controller: Controller) -> str:
    """Return scenario, controller, policy keywords and observed features as JSON."""
    keywords = {name: getattr(form.config, name) for name in PolicyKeywords.model_fields}
    keywords["observation"] = observation_name(form.config.observation)
    record = {
        "format": 2,
        "scenario": form.scenario.name,
        "controller": name_and_changes(controller),
        "keywords": keywords,
        "observes": form.observes,
        "sizes": form.sizes if form.config.randomise else [],
    }
    return json.dumps(record)


def observation_name(observation: object) -> str:
    """Return the observation as written in the name of a policy: `layer+module:Class`."""
    listed = observation if isinstance(observation, list | tuple) else [observation]
    return "+".join(each if isinstance(each, str) else _path(each) for each in listed)


def _path(observation: object) -> str:
    kind = observation if isinstance(observation, type) else type(observation)
    mark = "" if kind is observation or _is_as_made(observation) else WITH_ARGUMENTS
    return f"{kind.__module__}:{kind.__qualname__}{mark}"


def _is_as_made(observation: object) -> bool:
    """Return whether the class without arguments makes an equal instance."""
    try:
        return bool(type(observation)().__getstate__() == observation.__getstate__())
    except Exception:  # the class needs arguments, or the state cannot be compared
        return False


def name_and_changes(controller: Controller) -> str:
    """Return the name of a controller, with the layers and parameters that differ from it."""
    name = controller.name
    if name not in CONTROLLERS or not hasattr(controller, "parameters"):
        return name
    both: tuple[Any, Any] = controller, CONTROLLERS[name]
    now, usual = ({**getattr(each, "layer_names", {}), **each.parameters} for each in both)
    changes = [f"{k}={v}" for k, v in now.items() if usual.get(k) != v]
    return f"{name}:{','.join(changes)}" if changes else name
