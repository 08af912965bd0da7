"""Form of a policy: its observation and action in a scenario, under its keywords."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.actions import ActionForm
from swarm_forage_env.envs.config import EnvConfig, n_steps
from swarm_forage_env.envs.decision_kernels import Scaling
from swarm_forage_env.envs.observations import (
    Addition,
    added,
    checked_features,
    normalised,
    resized,
    stacked,
    typical_sizes,
)
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.interface import REPLACE
from swarm_forage_env.observed_fields import FieldLayout
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.spaces import Feature, Layout, widest
from swarm_forage_env.task import task_of

BOUND = re.compile(r"of [-+.e0-9]+ ")
"""Start of the unit of a feature divided by its bound, which depends on the scenario."""

OF_BOUND = "of its bound, in "
"""Replacement of BOUND in `observes`; a feature of bound 1 is not divided and has neither."""


class PolicyForm:
    """Observation and action of a policy for one robot, under the keywords of an environment."""

    def __init__(
        self, scenarios: Sequence[BaseScenario], config: EnvConfig, sizes: Sequence[float] = ()
    ) -> None:
        """Make the form for the first of these scenarios, with bounds that hold in all of them.

        `sizes` are the typical sizes of the features in another form; empty: those of these bounds.
        Raises ConfigError or UnknownNameError for keywords that the scenario's task does not have.
        """
        _check_step_on(config)
        self.scenario = scenario = scenarios[0]
        self.task = task_of(scenario)
        if config.learn not in self.task.policies:
            raise UnknownNameError("layer to learn", config.learn, self.task.policies)
        self.policy = policy = self.task.policies[config.learn]
        usual = min(policy.decision_period, scenario.n_ticks)
        period = {"decision_period": config.decision_period or usual}
        self.config = config = config.model_copy(update=period)
        self.max_cycles = n_steps(scenario, config)
        self.agents = self.task.agents(scenario.task.n_robots)
        self.has_walk = config.walk and bool(policy.walk)
        """Whether the direction of the random walk is observed if the robot has no goal."""
        layouts = [policy.layout(each, self.has_walk) for each in scenarios]
        longest = max(layouts, key=len)
        self.shown = FieldLayout(widest(layouts), longest.paths, longest.sizes)
        """Layout of the observed inputs of the layer."""
        self.sizes: list[float] = []
        """Typical size of each feature of a single observation; empty without normalisation."""
        self.additions: list[tuple[Addition, int, Layout]] = []
        """Additions to the observation, each with the index of its first feature and its layout."""
        self.observed, self.scaling = self._observed(sizes)
        """Layout and scaling of a single observation, before stacking."""
        self.layout: Layout = stacked(self.observed, config.stack)
        self.observation_space: Box = self.layout.box()
        self.action = ActionForm(self.task, policy, config)
        self.action_space: Box | Discrete = self.action.space

    def _observed(self, sizes: Sequence[float]) -> tuple[Layout, Scaling]:
        has_layer, parts = added(self.config.observation, self.policy)
        target, direction = self.policy.target, -1
        if not has_layer:
            self.shown = FieldLayout((), (), self.shown.sizes)
        layout: Layout = self.shown
        if (self.config.normalise or self.has_walk) and has_layer and target is not None:
            direction = layout.names.index(f"{target}.x")
            if not self.has_walk:
                ends = (Feature(f"{target}.direction.{axis}", "ratio", -1.0, 1.0) for axis in "xy")
                layout = Layout((*layout, *ends))
        where = direction, len(layout) - 2, self.has_walk
        for part in parts:
            features = checked_features(part, self.scenario, self.agents)
            self.additions.append((part, len(layout), features))
            layout = layout if not features else Layout((*layout, *features))
        twice = sorted({name for name in layout.names if layout.names.count(name) > 1})
        if twice or not layout:
            raise ConfigError(f"observation: features must have different names; repeated: {twice}")
        if not self.config.normalise:
            return layout, (*where, np.zeros(0, np.float32), np.zeros(0, np.bool_))
        layout = resized(layout, sizes) if sizes else layout
        self.sizes = [each.size for each in layout]
        return normalised(layout), (*where, *typical_sizes(layout))

    def check_bounds(self, scenario: BaseScenario) -> None:
        """Raise ConfigError if the layer's inputs exceed these bounds in another scenario."""
        check_within(self.shown, self.policy.layout(scenario, self.has_walk), "observation")

    def mark_replaced_layers(self, action: Array, masks: Mapping[str, Any]) -> None:
        """Mark the layers that the policy replaces, for the robots given for each layer."""
        for layer in self.policy.replaces:
            action[layer][masks[layer]] = self.action.motion if layer == "motion" else REPLACE
        if "motion" in self.policy.replaces and self.policy.walk:
            action["has_reflexes"][masks["motion"]] = self.action.has_reflexes
            action["is_walking"][masks["motion"]] = self.has_walk

    @property
    def observes(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of each feature of an observation, independent of bounds."""
        return tuple((each.name, BOUND.sub(OF_BOUND, each.unit)) for each in self.layout)


def _check_step_on(config: EnvConfig) -> None:
    if config.step_on == "tick":
        return
    if config.learn != "weighting":
        raise ConfigError(
            "step_on='exchange': needs learn='weighting'; others also act between exchanges"
        )
    if config.decision_period not in (None, 1):
        raise ConfigError("step_on='exchange': excludes decision_period; leave that out")


def check_within(layout: Layout, other: Layout, kind: str) -> None:
    """Raise ConfigError if features of another scenario exceed their bounds in this layout."""
    bounds = {each.name: each for each in other}
    for here in layout:
        there = bounds.get(here.name, here)
        if not here.low <= there.low <= there.high <= here.high:
            raise ConfigError(
                f"options: {here.name} would go from {there.low:.3g} to {there.high:.3g}"
                f" {here.unit}, but in the {kind} space of this environment it goes from"
                f" {here.low:.3g} to {here.high:.3g}; set the parameter when the environment is"
                " made, or randomise it"
            )
