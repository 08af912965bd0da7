"""From keywords to parts: every API in this folder has its keywords read and checked here."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NoReturn

from swarm_forage_env.controllers import Controllers, find_controllers
from swarm_forage_env.envs.config import EnvConfig, chosen_robots
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.interface import ChecksScenarios, Controller, has_talk, is_everything
from swarm_forage_env.mixed import members_of, with_members
from swarm_forage_env.parameters import BaseScenario, leaves, resolve, validated
from swarm_forage_env.scenarios import ScenarioSource, find_scenario
from swarm_forage_env.task import Task, task_of


@dataclass(frozen=True)
class EnvParts:
    """What an environment is made of."""

    scenario: BaseScenario
    config: EnvConfig
    controller: Controller
    task: Task


def checked_parts(
    scenario: ScenarioSource, controller: Controllers | None, options: Mapping[str, object]
) -> EnvParts:
    """The parts that the keywords of `parallel_env` name.

    `options` are the fields of `EnvConfig` and changes of single numbers of the scenario.
    UnknownNameError or ConfigError for what cannot be used.
    """
    own = {name: options[name] for name in EnvConfig.model_fields if name in options}
    config = validated(EnvConfig, own)
    overrides = {name: value for name, value in options.items() if name not in own}
    chosen = _overridden(scenario, overrides)
    task = task_of(chosen)
    found = find_controllers(controller, chosen)
    _check_learns(config, task)
    _check_shaping(config.shaping, chosen, task)
    if config.learn == "everything":
        found = _beside_everything(found, controller is not None, config, chosen)
    else:
        _check_leaves_a_layer(found, config, chosen)
    if isinstance(found, ChecksScenarios):
        found.check_supports(chosen)
    if config.learn == "weighting" and not has_talk(found):
        _refuse(found, "nobody talks, so that there is nothing to weigh; choose one that does")
    if config.decision_period is None:
        usual = min(task.policies[config.learn].decision_period, chosen.n_ticks)
        config = config.model_copy(update={"decision_period": usual})
    return EnvParts(chosen, config, found, task)


def _check_learns(config: EnvConfig, task: Task) -> None:
    if config.learn not in task.policies:
        raise UnknownNameError("layer to learn", config.learn, task.policies)
    if config.residual and not task.residuals:
        raise ConfigError(f"residual=True: cannot be had in the task {task.name}; leave it out")
    if config.residual and config.learn not in task.residuals:
        raise UnknownNameError("layer to learn as a residual", config.learn, task.residuals)
    if config.step_on == "exchange":
        _check_exchanges(config)


def _check_shaping(weight: float, scenario: BaseScenario, task: Task) -> None:
    """ConfigError for a weight of the potential under which a round trip would cost something."""
    most, why = 0.0, f"the task {task.name} has no potential"
    if task.potential is not None:
        most, why = task.potential.max_shaping(scenario)
    if weight > most:
        raise ConfigError(f"shaping={weight:g}: {why}; must be at most {most:g}")


def _beside_everything(
    controller: Controller, is_given: bool, config: EnvConfig, scenario: BaseScenario
) -> Controller:
    """What runs the swarm where some robots learn everything: the given controller all others."""
    task, n_robots = task_of(scenario), scenario.task.n_robots
    policy = task.raw_control
    assert policy is not None
    learners = chosen_robots(config.learners, task.agents(n_robots))
    if len(learners) < n_robots:
        return with_members(controller, dict.fromkeys(learners, policy), n_robots)
    if is_given:
        _refuse(
            controller,
            "none runs where learn='everything' and all robots learn; leave it out, name the"
            " `learners`, or learn 'motion'",
        )
    return policy


def _check_leaves_a_layer(
    controller: Controller, config: EnvConfig, scenario: BaseScenario
) -> None:
    n_robots = scenario.task.n_robots
    members = members_of(controller, n_robots)
    for robot in chosen_robots(config.learners, task_of(scenario).agents(n_robots)):
        if is_everything(members[robot]):
            _refuse(
                members[robot],
                f"is everything, so that it leaves no layer of robot {robot} to learn; give it to"
                " robots that do not learn, by `learners`, or take a policy of the motion",
            )


def _overridden(scenario: ScenarioSource, overrides: Mapping[str, object]) -> BaseScenario:
    """The scenario with its overrides; UnknownNameError for what is no keyword and no number."""
    chosen = find_scenario(scenario)
    keywords = (*EnvConfig.model_fields, "controller", "render_mode")
    known = {**leaves(chosen.model_dump()), **dict.fromkeys(keywords)}
    for name in overrides:
        resolve(name, known, "keyword or scenario parameter")
    changed: BaseScenario = find_scenario(chosen, overrides)
    return changed


def _refuse(controller: Controller, why: str) -> NoReturn:
    raise ConfigError(f"controller '{controller.name}': {why}")


def _check_exchanges(config: EnvConfig) -> None:
    if config.learn != "weighting":
        raise ConfigError("step_on='exchange': only learn='weighting' acts in exchanges alone")
    if config.decision_period not in (None, 1):
        raise ConfigError("step_on='exchange': goes with no decision_period; leave it out")
    if not isinstance(config.reward, str):
        raise ConfigError("step_on='exchange': goes with reward='own' or 'team' alone")
