"""Controllers whose learned layer is a policy of another trainer: `sb3:model.zip`.

The rest of the loop is hand-written, by the controller that the policy was trained beside. What
the policy observes and how its actions are read is the code of the environments, so that a policy
does in an evaluation what it did in training. It is asked for one world at a time: the rounding of
a matrix product depends on its number of rows, and an episode must not depend on its neighbours.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from pydantic import Field, field_validator

from baselines.controller import LayeredController
from baselines.controllers import SINGLE, SUBSUMPTION
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.arrays import Array, Bool, Float32
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.config import EnvConfig
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import CORRECT, KEEP, REPLACE, RULE, Controller, RunningController
from swarm_forage_env.parameters import Count, Part, Positive, validated
from swarm_forage_env.task import task_of
from training.policy_card import PolicyCard, read_policy_card

Predict = Callable[[Float32[Array, "robots numbers"]], Any]
"""The actions of the robots of a world, from what each of them observes."""


class Policy(Part):
    """A policy, and the keywords of `parallel_env` under which it was trained."""

    learn: str = Field("motion", description="Layer that the policy takes the place of")
    action: str = Field("", description="Form in which it steers: drive, or wheels; none: drive")
    sharpest_turn: Positive = Field(0.3, description="Sharpest turn of `drive`")
    discrete: bool | tuple[Count, Count] = Field(
        False, description="Its actions are choices; 3x5: of 3 speeds times 5 turns"
    )
    normalise: bool = Field(True, description="Its observations lie in [-1, 1]; false: SI units")
    observation: Any = Field("layer", description="What it observes, as layer+previous_action")
    stack: Count = Field(1, description="Observations of so many decisions together")
    decision_period: Count | None = Field(
        None, description="Ticks for which an action is held; none: as suits the layer"
    )
    residual: bool = Field(False, description="Its wheels are added to the hand-written ones")

    @field_validator("action", mode="before")
    @classmethod
    def _usual(cls, action: Any) -> Any:  # noqa: ANN401 whatever was given
        return "" if action is None else action

    @field_validator("discrete", mode="before")
    @classmethod
    def _grid(cls, discrete: Any) -> Any:  # noqa: ANN401 whatever was given
        is_grid = isinstance(discrete, str) and "x" in discrete
        return tuple(discrete.split("x")) if is_grid else discrete

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files, other than source code, that its output depends on."""
        return ()

    @property
    def source(self) -> str:
        """What a refusal calls it."""
        return type(self).__name__

    def config(self) -> EnvConfig:
        """The keywords, as an environment has them."""
        names = self.observation
        listed = names.split("+") if isinstance(names, str) else names
        own = [each for each in listed if ":" in each] if isinstance(names, str) else []
        if own:
            raise ConfigError(
                f"policy {self.source}: observes {own[0]}, a class of its trainer's; make the"
                " controller in Python, with policy_controller(..., observation=[...])"
            )
        given = {name: getattr(self, name) for name in Policy.model_fields}
        given |= {"action": self.action or None, "observation": listed}
        return validated(EnvConfig, given)

    def card(self) -> PolicyCard | None:
        """What it was trained on, where that is known."""
        return None

    def start(self, form: PolicyForm) -> Predict:
        """The policy, ready to be asked; ConfigError if it does not fit."""
        raise NotImplementedError


class PolicyFile(Policy):
    """A policy that is kept in a file."""

    file: str = Field("", description="The file")

    @property
    def path(self) -> Path:
        """The file; ConfigError if there is none."""
        path = Path(self.file)
        if not self.file:
            raise ConfigError("policy: which file? Name it after the colon, as in sb3:model.zip")
        if not path.is_file():
            raise ConfigError(f"policy {path}: there is no such file")
        return path

    @property
    def reads(self) -> tuple[Path, ...]:
        """The file."""
        return (self.path,)

    @property
    def source(self) -> str:
        """The file's name as it was given."""
        return self.file

    def card(self) -> PolicyCard | None:
        """The card beside the file."""
        return read_policy_card(self.path)


class FunctionPolicy(Policy):
    """A function of Python's, from what the robots of a world observe to their actions."""

    function: Any = None

    def start(self, form: PolicyForm) -> Predict:
        """The function itself."""
        predict: Predict = self.function
        return predict


@dataclass(frozen=True)
class PolicyController(LayeredController):
    """A policy in the place of a layer, or of everything, and hand-written layers for the rest."""

    policy: Policy

    main_parameter = "file"
    """What a name says after its colon: `sb3:model.zip`."""

    @property
    def layers(self) -> dict[str, Part]:
        """The policy, and the parameters of each layer."""
        return {**super().layers, "policy": self.policy}

    @property
    def layer_names(self) -> dict[str, str]:
        """The name of each layer, and of the kind of policy."""
        own = type(self.policy).__name__
        return {**self.hand_written.layer_names, "policy": own}

    @property
    def is_everything(self) -> bool:
        """The policy leaves no layer to anybody else."""
        return self.policy.learn == "everything"

    @property
    def hand_written(self) -> LayeredController:
        """The layers alone."""
        return LayeredController(self.name, self.estimator, self.weighting, self.motion)

    def with_parameters(self, values: Mapping[str, Any]) -> "PolicyController":
        """The same controller with some parameters changed, its file and its controller first.

        A file brings its card: the keywords of its training, and the controller beside which it
        was trained. Parameters that are given count for more.
        """
        given, changed = dict(values), self
        file = given.pop("policy.file", given.pop("file", None))
        if file is not None:
            policy = validated(type(self.policy), {"file": file})
            changed = replace(self, policy=policy)._as_on_card()
        if "controller" in given:
            changed = changed._beside(given.pop("controller"))
        found = super(PolicyController, changed).with_parameters(given)
        assert isinstance(found, PolicyController)
        return found

    def build(  # type: ignore[override]  # a running controller of another class
        self,
        world: Any,  # noqa: ANN401 of any task
        seeds: Sequence[int],
        each: Sequence[Any],
    ) -> "RunningPolicy":
        """The running controller of a block of worlds; ConfigError if the policy does not fit."""
        if any(own.policy != self.policy for own in each):
            raise ConfigError(f"policy {self.policy.source}: all worlds of a block need the same")
        under = [own.under(world.scenario) for own in each]
        inner = under[0].build(world, seeds, under)
        return self.over(world, inner, range(world.n_robots))

    def under(self, scenario: Any) -> Any:  # noqa: ANN401 layers or none, in any task
        """What does the rest: hand-written layers, or nothing beside a policy of everything."""
        task = task_of(scenario)
        if self.is_everything and task.no_layers is not None:
            return task.no_layers
        return self.hand_written

    def language(self, scenario: Any) -> Any:  # noqa: ANN401 of any task
        """That of what does the rest."""
        if self.is_everything:
            return self.under(scenario).language(scenario)
        return super().language(scenario)

    def over(
        self,
        world: Any,  # noqa: ANN401 of any task
        inner: RunningController,
        robots: Sequence[int],
    ) -> "RunningPolicy":
        """The policy of some robots, over what does the rest; ConfigError if it does not fit."""
        form = self.form(world.scenario)
        return RunningPolicy(world, inner, form, self._started(form, robots), robots)

    def check_usable(self, scenario: Any) -> None:  # noqa: ANN401 of any task
        """ConfigError or UnknownNameError if a layer or the policy does not fit the scenario."""
        if not self.is_everything:
            self.hand_written.check_usable(scenario)
        form = self.form(scenario)
        self._started(form, form.everybody)

    def check_supports(self, scenario: Any) -> None:  # noqa: ANN401 of any task
        """ConfigError if a hand-written layer is not made for the world of this scenario."""
        if not self.is_everything:
            super().check_supports(scenario)

    def form(self, scenario: Any) -> PolicyForm:  # noqa: ANN401 of any task
        """What the policy is shown and gives; ConfigError if its card says something else."""
        path = 0.0 if self.is_everything else self.message_path
        form = PolicyForm([scenario], self.policy.config(), path)
        card = self.policy.card()
        if card is not None:
            _check_observes(self.policy, card.observes, form.observes)
        return form

    def _started(self, form: PolicyForm, robots: Sequence[int]) -> Predict:
        """What the layers take of the policy of some robots, after it has been asked once."""
        predict, usable = self.policy.start(form), usable_rows(form, robots, self.policy.source)

        def steer(observed: Float32[Array, "robots numbers"]) -> Float32[Array, "robots n"]:
            return usable(predict(observed))

        steer(form.dummy(robots))
        return steer

    def _as_on_card(self) -> "PolicyController":
        """The same, under the keywords and beside the controller on the policy's card."""
        card = self.policy.card()
        if card is None:
            return self
        policy = validated(type(self.policy), {**self.policy.model_dump(), **card.keywords})
        changed = replace(self, policy=policy)
        return changed if changed.is_everything else changed._beside(card.controller)

    def _beside(self, controller: str | Controller) -> "PolicyController":
        """The same beside the layers of another controller."""
        found = find_controller(controller)
        if not isinstance(found, LayeredController):
            raise ConfigError(f"controller '{controller}': must be made of layers")
        return replace(
            self, estimator=found.estimator, weighting=found.weighting, motion=found.motion
        )


class RunningPolicy:
    """A policy of some robots and what does the rest, on a block of worlds.

    It acts where no learner does, so that its robots can be the team-mates of some.
    """

    has_rules = True
    """The policy is asked about all worlds at once."""

    def __init__(
        self,
        world: Any,  # noqa: ANN401 of any task
        inner: RunningController,
        form: PolicyForm,
        steer: Predict,
        robots: Sequence[int],
    ) -> None:
        """The policy has not been asked yet."""
        self._world, self._inner, self._form, self._steer = world, inner, form, steer
        self._robots = np.array(robots)
        self.minds = inner.minds
        self._frames = form.frames(world.n_worlds)
        self._held = np.zeros((*world.robots.shape, len(form.policy.action)), np.float32)
        self._own: dict[str, Bool[Array, "worlds robots"]] | None = None

    def observe(self, first: int, last: int) -> None:
        """Take in what the worlds first .. last - 1 gave back."""
        self._inner.observe(first, last)

    def consult(self) -> None:
        """Ask the policy in worlds where a decision is due, then the rules written in NumPy."""
        if self._own is None:
            self._own = self._take_over()
        ticks, period = self._world.worlds["ticks"], self._form.config.period
        due = np.flatnonzero(ticks % period == 0)
        if len(due):
            self._held[ticks == 0] = 0.0
            seen = self._seen(ticks // period, due)
            for world in due:
                self._held[world, self._robots] = self._steer(seen[world, self._robots])
            self._act(self._own)
        self._inner.consult()

    def decide(self, first: int, last: int) -> None:
        """Write the next commands of the worlds first .. last - 1."""
        self._inner.decide(first, last)

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world; the policy does at its first tick."""
        self._inner.reset(world, seed)

    def numbers_in(self, world: int, scenario: Any) -> Any:  # noqa: ANN401 of any task
        """The numbers of one world's layers in another scenario."""
        return self._inner.numbers_in(world, scenario)

    def renumber(self, world: int, numbers: Any) -> None:  # noqa: ANN401 as above
        """Go by these numbers in one world from now on."""
        self._inner.renumber(world, numbers)

    def snapshot(self) -> dict[str, Any]:
        """What was observed and is being done, whose robots are the policy's, and all the rest."""
        return {
            "frames": self._frames.snapshot(),
            "held": self._held.copy(),
            "own": deepcopy(self._own),
            "rest": self._inner.snapshot(),
        }

    def restore(self, kept: Mapping[str, Any]) -> None:
        """Go on as when that snapshot was taken."""
        self._frames.restore(kept["frames"])
        self._held[...] = kept["held"]
        self._own = deepcopy(kept["own"])
        self._inner.restore(kept["rest"])

    def _take_over(self) -> dict[str, Bool[Array, "worlds robots"]]:
        """Mark as the policy's what no learner has; which robots, for each layer."""
        action, own = self._world.robots["action"], {}
        for layer in self._form.policy.replaces:
            mine = np.zeros(action.shape, np.bool_)
            mine[:, self._robots] = True
            own[layer] = mine & ((action[layer] == KEEP) | (action[layer] == RULE))
            is_residual = self._form.config.residual and layer == "motion"
            action[layer][own[layer]] = CORRECT if is_residual else REPLACE
        return own

    def _seen(self, decisions: Array, due: Array) -> Float32[Array, "worlds robots numbers"]:
        """What every robot observes; right in the worlds where a decision is due."""

        def share_left() -> Array:
            return np.asarray(1.0 - np.minimum(decisions / self._form.max_cycles, 1.0))

        seen = self._form.observe(self._world, self._inner, share_left, self._held)
        self._frames.add(seen, due)
        return self._frames.begin(seen, due[decisions[due] == 0])

    def _act(self, own: Mapping[str, Bool[Array, "worlds robots"]]) -> None:
        """Write the actions, and leave those of learners as they were."""
        action, robots = self._world.robots["action"], self._robots
        before = None if all(mask[:, robots].all() for mask in own.values()) else action.copy()
        self._form.policy.act(self._world, self._inner, robots, self._held[:, robots])
        if before is None:
            return
        fields = {"weighting": "weight", "motion": self._form.task.commanded}
        for layer, mask in own.items():
            field = fields[layer]
            action[field][~mask] = before[field][~mask]


def policy_controller(
    function: Predict,
    controller: str | Controller = "ssgikf",
    name: str = "policy",
    **keywords: Any,  # noqa: ANN401 of a policy
) -> PolicyController:
    """A controller of a function that maps what the robots of a world observe to their actions.

        team = policy_controller(model.predict_rows, learn="motion", decision_period=5)
        env = parallel_env("es1", controller=team, learners=1)

    The `keywords` are those of `parallel_env` under which it was trained.
    """
    policy = validated(FunctionPolicy, {"function": function, **keywords})
    return named_policy(name, policy)._beside(controller)


def named_policy(name: str, policy: Policy) -> PolicyController:
    """A controller of a policy beside the layers of `ssgikf`."""
    return PolicyController(name, SINGLE, SGIKF(), SUBSUMPTION, policy)


def usable_rows(
    form: PolicyForm, robots: Sequence[int], source: str
) -> Callable[[Any], Float32[Array, "robots n"]]:
    """What turns the actions of some robots into what the layers take, clipped to their bounds.

    ConfigError for what the action space does not hold.
    """
    actions, space = form.actions(robots), form.action_space

    def rows(given: Any) -> Float32[Array, "robots n"]:  # noqa: ANN401 whatever the policy gives
        found = np.asarray(given)
        if isinstance(space, Box) and found.shape[1:] == space.shape and found.dtype.kind == "f":
            found = np.clip(found, space.low, space.high)
        try:
            return actions.rows(found)
        except ConfigError as error:
            raise ConfigError(f"policy {source}: {error}") from None

    return rows


def _check_observes(
    policy: Policy, trained: Sequence[tuple[str, str]], here: Sequence[tuple[str, str]]
) -> None:
    """ConfigError for the first number that was another one in training."""
    both = trained, here
    for k in range(max(map(len, both))):
        old, new = ("{} [{}]".format(*each[k]) if k < len(each) else "nothing" for each in both)
        if old != new:
            raise ConfigError(
                f"policy {policy.source}: number {k} of its observations was {old} in training"
                f" and is {new} here; take the scenario and the keywords that it was trained with"
            )
