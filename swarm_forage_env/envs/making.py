"""From keywords to worlds: every API in this folder makes its batch here."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.batch import Batch
from swarm_forage_env.envs.teammates import AmongTeamMates
from swarm_forage_env.envs.terms import Terms
from swarm_forage_env.envs.waypoints import WaypointBatch
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import ControllerRecipe
from swarm_forage_env.scenario import leaves, resolve, validated
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints_scenario import AnyScenario, WaypointsScenario

AnyBatch = Batch | WaypointBatch


def make_batch(
    seeds: Sequence[int],
    options: Mapping[str, Any],
    scenario: str | Path | AnyScenario = "es1",
    controller: str | ControllerRecipe | None = None,
    single_learner: bool = False,
) -> AnyBatch:
    """One world for each seed, under the keywords of `parallel_env`.

    `options` are the fields of `Terms` and changes of single numbers of the scenario. With a
    `single_learner` the actions of the first robot of each world count, and the others keep
    the controller's layers. UnknownNameError or ConfigError for what cannot be used.
    """
    terms = validated(
        Terms, {name: options[name] for name in Terms.model_fields if name in options}
    )
    overrides = {name: value for name, value in options.items() if name not in Terms.model_fields}
    chosen = _overridden(scenario, overrides)
    waypoints = isinstance(chosen, WaypointsScenario)
    recipe = find_controller(controller or ("boids-adaptive" if waypoints else "ssgikf"))
    if controller is not None and terms.learn == "everything":
        _refuse(recipe, "none runs where learn='everything'; leave it out, or learn 'motion'")
    if terms.learn == "weighting" and not (waypoints or getattr(recipe, "talks", True)):
        _refuse(recipe, "nobody talks, so that there is nothing to weigh; choose one that does")
    if terms.residual and (single_learner or waypoints):
        where = "a single learner" if single_learner else "robots that visit waypoints"
        raise ConfigError(f"residual=True: cannot be had for {where}; leave it out")
    if single_learner:
        _check_shares_a_language(terms)
        recipe = AmongTeamMates(recipe)
    if isinstance(chosen, WaypointsScenario):
        return WaypointBatch(chosen, terms, recipe, seeds)
    return Batch(chosen, terms, recipe, seeds)


def _overridden(scenario: str | Path | AnyScenario, overrides: Mapping[str, Any]) -> AnyScenario:
    """The scenario with its overrides; a misspelt keyword is told from a misspelt parameter."""
    chosen = find_scenario(scenario)
    keywords = (*Terms.model_fields, "controller", "render_mode")
    known = {**leaves(chosen.model_dump()), **dict.fromkeys(keywords)}
    for name in overrides:
        resolve(name, known, "keyword or scenario parameter")
    return find_scenario(chosen, overrides)


def _refuse(recipe: ControllerRecipe, why: str) -> NoReturn:
    """A ConfigError that names the controller."""
    raise ConfigError(f"controller '{getattr(recipe, 'name', recipe)}': {why}")


def _check_shares_a_language(terms: Terms) -> None:
    """ConfigError for a single learner of everything."""
    if terms.learn == "everything":
        raise ConfigError(
            "learn='everything': what a single learner would say means nothing to hand-written"
            " team-mates; learn 'weighting', 'motion' or 'both', or all robots at once, as in"
            " SwarmForage/ES1-Joint-v0"
        )
