"""Action forms: action spaces, checks of actions, and conversion to the inputs of the layers."""

import math
from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
from gymnasium.spaces import Box, Discrete

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import bind, entry_point
from swarm_forage_env.envs import decision_kernels as kernels
from swarm_forage_env.envs.config import MAX_CHOICES, EnvConfig
from swarm_forage_env.envs.decision_kernels import Form
from swarm_forage_env.errors import ConfigError, UnknownNameError, shown
from swarm_forage_env.interface import CORRECT, COURSE, REPLACE, Kernel
from swarm_forage_env.policy_interface import PolicyInterface, Steering
from swarm_forage_env.spaces import Feature, Layout
from swarm_forage_env.task import Task

NOT_FINITE = "find its cause, such as a division by 0, or weights that diverged in training"
"""Advice in the error of an action that is NaN or infinite."""

LEVELS = 3
"""Default number of levels of a weight in a discrete action."""

Raw = Float32[Array, "rows numbers"]
"""Inputs of the layers, one row for each robot: weights, motion command and message."""


class ActionForm:
    """Action space of a policy, and the conversion of its actions to inputs of the layers."""

    def __init__(self, task: Task, policy: PolicyInterface, config: EnvConfig) -> None:
        """Make the form; ConfigError or UnknownNameError if the task does not have it."""
        self._policy = policy
        self._steering = steering = _steering(task, policy, config)
        self.has_reflexes = _has_reflexes(policy, steering, config)
        """Whether the reflexes of the hand-written motion override the policy."""
        is_course = steering is not None and steering.is_course
        self.motion = CORRECT if config.residual else COURSE if is_course else REPLACE
        """Effect of an action on the hand-written motion: CORRECT, COURSE or REPLACE."""
        self._is_symmetric = config.normalise and policy.n_weights > 0
        self.layout = self._layout()
        """Layout of a continuous action."""
        own = None if steering is None else steering.command
        by = config.sharpest_turn
        if config.residual:
            own, by = kernels.share_of_command, config.residual
        n_symmetric = policy.n_weights if self._is_symmetric else 0
        no_choices = np.zeros((0, len(policy.action)), np.float32)
        self.space: Box | Discrete = self.layout.box()
        self.conversion: Form = (
            no_choices, n_symmetric, -1 if own is None else policy.n_weights, by
        )  # fmt: skip
        """Parameters of the conversion to layer inputs: a `Form` of `decision_kernels`."""
        self.functions: dict[str, Kernel] = {
            "write_raw": kernels.raw_of_continuous, "command": own or kernels.as_command
        }  # fmt: skip
        """Functions bound to the free names of the templates of a decision."""
        if config.discrete:
            self.choices = self._choices(config.discrete)
            self.conversion = self.to_raw(self.choices), *self.conversion[1:]
            self.functions = {"write_raw": kernels.raw_of_discrete}
            self.space = Discrete(len(self.choices))
        self.is_discrete = bool(config.discrete)
        """Whether an action is the index of a choice instead of an array of floats."""
        self.shape = () if self.is_discrete else (len(self.layout),)
        """Shape of the action of one robot."""

    @property
    def wanted(self) -> str:
        """Words for the action of one robot: the names of its numbers, or the range of a choice."""
        if self.is_discrete:
            return f"a whole number from 0 to {len(self.choices) - 1}"
        return ", ".join(self.layout.names)

    def to_raw(self, actions: Array) -> Raw:
        """Return the inputs of the layers for these actions, one row for each robot."""
        raw = np.empty((1, len(actions), len(self._policy.action)), np.float32)
        bind(kernels.convert, self.functions)(actions[None], self.conversion, raw, (0, 1))
        return np.asarray(raw[0])

    def _layout(self) -> Layout:
        raw, n = self._policy.action, self._policy.n_weights
        weights: Sequence[Feature] = raw[:n]
        if self._is_symmetric:
            unit = "-1 keeps the own, 1 takes the heard"
            weights = [Feature(each.name, unit, -1.0, 1.0) for each in weights]
        if self._steering is None:
            return Layout((*weights, *raw[n:]))
        return Layout((*weights, *self._steering.layout, *raw[n + 2 :]))

    def _choices(self, discrete: bool | tuple[int, int]) -> Float32[Array, "choices numbers"]:
        """Return the continuous action of each choice; its last part varies fastest."""
        grid = discrete if isinstance(discrete, tuple) else None
        _check_choices(discrete, math.prod(grid or ()))  # before the choices are built
        parts = [*self._weights(grid), self._steers(grid), self._policy.messages]
        _check_choices(discrete, math.prod(map(len, parts)))
        rows = [np.concatenate(each) for each in product(*(p for p in parts if p.shape[1]))]
        return np.array(rows, np.float32)

    def _weights(self, grid: tuple[int, int] | None) -> list[Float32[Array, "levels 1"]]:
        numbers = grid if grid is not None and self._steering is None else (LEVELS, LEVELS)
        levels = numbers[: self._policy.n_weights]
        return [
            np.linspace(feature.low, feature.high, n, dtype=np.float32)[:, None]
            for feature, n in zip(self.layout[: len(levels)], levels, strict=True)
        ]

    def _steers(self, grid: tuple[int, int] | None) -> Float32[Array, "choices 2"]:
        if self._steering is None:
            return np.zeros((1, 0), np.float32)
        if grid is None:
            alone = [(0.0, 0.0)] if self.motion == CORRECT else []  # no correction
            return np.array([*self._steering.choices, *alone], np.float32)
        levels = [np.linspace(-1.0, 1.0, n, dtype=np.float32) for n in grid]
        return np.array(list(product(*levels)), np.float32)


def _check_choices(discrete: bool | tuple[int, int], n_choices: int) -> None:
    if n_choices > MAX_CHOICES:
        raise ConfigError(
            f"discrete={shown(discrete)}: gives {shown(n_choices)} actions; must give at most"
            f" {MAX_CHOICES}, because a network has one output for each; choose fewer speeds and"
            " turns, or discrete=False for continuous actions"
        )


def _steering(task: Task, policy: PolicyInterface, config: EnvConfig) -> Steering | None:
    if config.residual and config.action in (None, "wheels"):
        return task.steerings["wheels"]
    if config.residual:
        raise ConfigError(
            f"action='{config.action}': a residual policy corrects wheel speeds; use"
            " action='wheels', or residual=0"
        )
    if config.action is not None and config.action not in task.steerings:
        raise UnknownNameError("form of action", config.action, task.steerings)
    if len(policy.action) == policy.n_weights or not task.steerings:
        return None  # weights only, or a task without steering
    return task.steerings[config.action or next(iter(task.steerings))]


def _has_reflexes(policy: PolicyInterface, steering: Steering | None, config: EnvConfig) -> bool:
    """Return whether reflexes override the policy; ConfigError for keywords that conflict."""
    is_course = steering is not None and steering.is_course
    if (is_course or config.reflexes) and not policy.walk:
        keyword = f"action='{config.action}'" if is_course else "reflexes=True"
        raise ConfigError(
            f"{keyword}: needs a hand-written motion beside the policy, and learn='{config.learn}'"
            " leaves none here; use learn='motion' in a foraging scenario, or leave it out"
        )
    if is_course and config.reflexes is False:
        raise ConfigError("reflexes=False: action='course' is steered by reflexes; use 'drive'")
    if config.residual and config.reflexes is not None:
        raise ConfigError(
            "reflexes: a residual policy corrects a hand-written motion, which has reflexes"
            " itself; leave out reflexes or residual"
        )
    if config.reflexes is not None:
        return config.reflexes
    drives = steering is not None and steering.command is not None
    return drives and bool(policy.walk) and not config.residual


class Actions:
    """Checker of the actions of all learners; its errors name the agent and the feature."""

    def __init__(self, agents: Sequence[str], form: ActionForm) -> None:
        self._agents, self.form = tuple(agents), form
        self._shape = (len(agents), *form.shape)

    def matrix(self, actions: Mapping[str, object]) -> Array:
        """Return one row for each agent; ConfigError or UnknownNameError for invalid actions."""
        try:
            stacked = np.array([actions[agent] for agent in self._agents])
            usable = self._usable(stacked) if len(actions) == len(self._agents) else None
        except (IndexError, KeyError, RuntimeError, TypeError, ValueError):
            usable = None  # the error is determined below
        if usable is None:
            raise self._complaint(actions)
        return usable

    def rows(self, actions: Array) -> Array:
        """Return the array, one row for each agent, after checks; ConfigError if invalid."""
        usable = self._usable(actions)
        if usable is None:
            if actions.shape[:1] != self._shape[:1]:
                raise ConfigError(f"actions of shape {actions.shape}: must be {self._shape}")
            raise self._complaint(dict(zip(self._agents, actions, strict=True)))
        return usable

    def _usable(self, actions: Array) -> Array | None:
        """Return the actions as kernels take them, or None if they are not in the action space."""
        if actions.shape != self._shape:
            return None
        if self.form.is_discrete:
            n = len(self.form.choices)
            if actions.dtype.kind not in "iu" or not ((actions >= 0) & (actions < n)).all():
                return None
            return actions.astype(np.int64, copy=False)
        if actions.dtype != np.float32 and actions.dtype.kind in "fiu":
            actions = actions.astype(np.float64)
        space = self.form.space
        assert isinstance(space, Box)
        if actions.dtype.kind == "f" and is_within(actions, space.low, space.high):
            return actions.astype(np.float32, copy=False)
        return None

    def _complaint(self, actions: object) -> Exception:
        if not isinstance(actions, Mapping):
            return ConfigError(f"actions={shown(actions)}: must be a dictionary by agent")
        for agent in actions:
            if agent not in self._agents:
                return UnknownNameError("agent", str(agent), self._agents)
        for agent in self._agents:
            if agent not in actions:
                return ConfigError(f"actions: {agent} has none; every agent needs one")
            complaint = self._complaint_about(actions[agent])
            if complaint:
                return ConfigError(f"action of {agent}: {complaint}")
        return ConfigError("actions: must be arrays of one number type for all agents")

    def _complaint_about(self, action: object) -> str:
        layout, wanted = self.form.layout, self.form.wanted
        if self.form.is_discrete:
            return self._complaint_about_choice(action)
        try:
            given = np.asarray(action)
            array = given.astype(np.float64, casting="same_kind")
        except (OverflowError, RuntimeError, TypeError, ValueError) as error:
            return f"{shown(action)}: must be finite numbers, {wanted}; {error}"
        if given.dtype == np.bool_:
            return f"{shown(action)}: must be numbers, {wanted}; these are booleans"
        if array.shape != self._shape[1:]:
            return f"shape {array.shape}: must be {self._shape[1:]}, for {wanted}"
        for feature, value, as_given in zip(layout, array, given, strict=True):
            if not feature.low <= value <= feature.high:
                advice = "clip it first with numpy.clip" if np.isfinite(value) else NOT_FINITE
                return (
                    f"{feature.name}={as_given!s}: must be from {feature.low:g} to {feature.high:g}"
                    f" [{feature.unit}]; {advice}"
                )
        return ""

    def _complaint_about_choice(self, choice: object) -> str:
        n = len(self.form.choices)
        if isinstance(choice, int | np.integer | np.ndarray):
            number = np.asarray(choice)
            if number.shape == () and number.dtype.kind in "iu" and 0 <= number < n:
                return ""
        return f"{shown(choice)}: must be {self.form.wanted}"


def as_array(actions: object) -> Array:
    """Return the actions as one array; ConfigError if NumPy cannot read them."""
    try:
        return np.asarray(actions)
    except (RuntimeError, TypeError, ValueError) as error:
        advice = "use float32 for continuous actions, int64 for discrete ones"
        raise ConfigError(f"actions={shown(actions)}: {error}; {advice}") from None


@entry_point
def is_within(
    rows: Array, low: Float32[Array, " numbers"], high: Float32[Array, " numbers"]
) -> bool:
    """Return whether every value of every row is within its bounds; NaN is not."""
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            if not low[k] <= rows[i, k] <= high[k]:
                return False
    return True
