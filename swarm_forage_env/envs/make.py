"""From keywords to worlds: every API in this folder makes its environment on arrays here."""

from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from swarm_forage_env.controllers import Controllers, find_controllers
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.config import EnvConfig
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.interface import Controller
from swarm_forage_env.parameters import leaves, resolve, validated
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import Task, task_of


def make_array_env(
    seeds: Sequence[int],
    options: Mapping[str, Any],
    scenario: Any = "es1",  # noqa: ANN401 a name, a file or a scenario of any task
    controller: Controllers | None = None,
    single_learner: bool = False,
) -> ArrayEnv:
    """One world for each seed, under the keywords of `parallel_env`.

    `options` are the fields of `EnvConfig` and changes of single numbers of the scenario. With a
    `single_learner` the actions of the first robot of each world count, and the others keep
    the controller's layers. UnknownNameError or ConfigError for what cannot be used.
    """
    own = {name: options[name] for name in EnvConfig.model_fields if name in options}
    config = validated(EnvConfig, own)
    overrides = {name: value for name, value in options.items() if name not in own}
    chosen = _overridden(scenario, overrides)
    task = task_of(chosen)
    found = find_controllers(controller, chosen)
    if config.learn not in task.policies:
        raise UnknownNameError("layer to learn", config.learn, task.policies)
    if controller is not None and config.learn == "everything":
        _refuse(found, "none runs where learn='everything'; leave it out, or learn 'motion'")
    if config.learn != "everything" and hasattr(found, "check_supports"):
        found.check_supports(chosen)
    if config.learn == "weighting" and not getattr(found, "talks", True):
        _refuse(found, "nobody talks, so that there is nothing to weigh; choose one that does")
    if config.residual:
        _check_residual(config, task, single_learner)
    if single_learner:
        _check_shares_a_language(config)
    return ArrayEnv(chosen, config, found, seeds, single_learner)


def _overridden(scenario: Any, overrides: Mapping[str, Any]) -> Any:  # noqa: ANN401 as above
    """The scenario with its overrides; a misspelt keyword is told from a misspelt parameter."""
    chosen = find_scenario(scenario)
    keywords = (*EnvConfig.model_fields, "controller", "render_mode")
    known = {**leaves(chosen.model_dump()), **dict.fromkeys(keywords)}
    for name in overrides:
        resolve(name, known, "keyword or scenario parameter")
    return find_scenario(chosen, overrides)


def _refuse(controller: Controller, why: str) -> NoReturn:
    """A ConfigError that names the controller."""
    raise ConfigError(f"controller '{getattr(controller, 'name', controller)}': {why}")


def _check_residual(config: EnvConfig, task: Task, single_learner: bool) -> None:
    """ConfigError where there is no motion to add a policy's to."""
    if not task.residuals:
        raise ConfigError(f"residual=True: cannot be had in the task {task.name}; leave it out")
    if config.learn not in task.residuals:
        raise UnknownNameError("layer to learn as a residual", config.learn, task.residuals)
    if single_learner:
        raise ConfigError("residual=True: cannot be had for a single learner; leave it out")


def _check_shares_a_language(config: EnvConfig) -> None:
    """ConfigError for a single learner of everything."""
    if config.learn == "everything":
        raise ConfigError(
            "learn='everything': what a single learner would say means nothing to hand-written"
            " team-mates; learn 'weighting', 'motion' or 'both', or all robots at once, as in"
            " SwarmForage/ES1-Joint-v0"
        )
