"""Options of an environment: learned layer, action, observation, reward, episode length."""

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from pydantic import Field, field_validator

from swarm_forage_env.errors import ConfigError, shown
from swarm_forage_env.parameters import (
    MAX_TICKS,
    BaseScenario,
    Count,
    NotNegative,
    Parameters,
    Positive,
    Share,
)

MAX_CHOICES = 4096
"""Discrete actions of a robot, at most: a network has one output for each."""

MAX_FRAMES = 1000
"""Observations of a robot together, at most: a network has an input for each of their numbers."""


class PolicyKeywords(Parameters):
    """What a policy replaces, what it observes, and how its actions are read."""

    learn: str = Field("motion", description="Layer that the policy takes the place of")
    residual: Share = Field(
        0.0,
        description="Share of the policy's wheels that is added to those of the hand-written"
        " motion; true: 1; 0: it replaces the motion",
    )
    action: str | None = Field(
        None, description="Form in which the policy steers: drive, course, or wheels; none: drive"
    )
    reflexes: bool | None = Field(
        None,
        description="The hand-written motion avoids and stands while talking, and the policy"
        " drives otherwise; none: wherever a policy drives",
    )
    walk: bool = Field(
        True, description="Without a goal, the course of the robot's random walk is shown"
    )
    sharpest_turn: Annotated[Positive, Field(le=1.0)] = Field(
        0.3, description="Sharpest turn of `drive`, as a share of the largest possible"
    )
    discrete: bool | tuple[Count, Count] = Field(
        False, description="Actions are choices: a few, or n speeds times m turns"
    )
    observation: object = Field(
        "layer", description="What is observed: names, or classes of the user's, one or several"
    )
    normalise: bool = Field(
        True, description="Observations and weights lie in [-1, 1]; false: SI units"
    )
    stack: Count = Field(1, description="Observations of so many decisions together")
    decision_period: Count | None = Field(
        None, description="Ticks for which an action is held; none: as suits the layer"
    )

    @field_validator("residual", mode="before")
    @classmethod
    def _as_share(cls, residual: object) -> object:
        return {"true": 1.0, "false": 0.0}.get(str(residual).lower(), residual)


class EnvConfig(PolicyKeywords):
    """What is learned, from what, for what reward, and how the world runs."""

    learners: object = Field(
        None, description="Robots that learn: how many, or which by name or number; none: all"
    )
    reward: object = Field("own", description="Who is credited with a round trip, or a callable")
    shaping: NotNegative = Field(0.0, description="Weight of the potential-based shaping; 0: none")
    discount: Share = Field(0.99, description="The learner's discount, for the shaping")
    step_on: Literal["tick", "exchange"] = Field(
        "tick", description="A step is a decision period, or ends with an exchange of a learner"
    )
    randomise: Mapping[str, object] = Field(
        default_factory=dict,
        description="Numbers of the scenario drawn anew for each episode, from low to high",
    )
    physics: str | None = Field(
        None, description="Engine that moves the robots; none: the one its scenario goes with"
    )
    threads: Count = Field(1, description="Threads that the worlds are spread over")
    max_cycles: Annotated[int, Field(ge=1, le=MAX_TICKS)] | None = Field(
        None, description="Decisions in an episode; none: as many as fit into the scenario's time"
    )

    @field_validator("discrete")
    @classmethod
    def _few_choices(cls, discrete: bool | tuple[int, int]) -> bool | tuple[int, int]:
        if isinstance(discrete, tuple):
            check_choices(discrete, math.prod(discrete))
        return discrete

    @field_validator("stack")
    @classmethod
    def _few_frames(cls, stack: int) -> int:
        if stack > MAX_FRAMES:
            raise ConfigError(
                f"stack={shown(stack)}: must be at most {MAX_FRAMES}, as a network has an input"
                " for each number of each of them; take fewer, or a longer decision_period"
            )
        return stack

    @property
    def period(self) -> int:
        """Ticks for which an action is held; 1 where none are said."""
        return self.decision_period or 1


def check_choices(discrete: bool | tuple[int, int], n_choices: int) -> None:
    """ConfigError for more discrete actions than a network should have outputs."""
    if n_choices > MAX_CHOICES:
        raise ConfigError(
            f"discrete={shown(discrete)}: makes {shown(n_choices)} actions; at most {MAX_CHOICES},"
            " as a network has an output for each; take fewer, or discrete=False for numbers"
        )


def n_steps(scenario: BaseScenario, config: EnvConfig) -> int:
    """Decisions in an episode: `max_cycles`, or as many as fit into the scenario's time."""
    if config.period > scenario.n_ticks:
        raise ConfigError(
            f"decision_period={shown(config.period)}: must be at most the {scenario.n_ticks} ticks"
            " of an episode"
        )
    return config.max_cycles or scenario.n_ticks // config.period


def chosen_robots(learners: object, agents: Sequence[str]) -> list[int]:
    """The numbers of the robots that learn, in order; ConfigError for what names none.

    >>> chosen_robots(2, ["epuck_0", "epuck_1", "epuck_2"])
    [0, 1]
    >>> chosen_robots(["epuck_2", 0], ["epuck_0", "epuck_1", "epuck_2"])
    [0, 2]
    """
    if learners is None:
        return list(range(len(agents)))
    if isinstance(learners, int) and not isinstance(learners, bool):
        if 1 <= learners <= len(agents):
            return list(range(learners))
        raise ConfigError(f"learners={shown(learners)}: must be from 1 to the {len(agents)} robots")
    named = [learners] if isinstance(learners, str) else learners
    if not isinstance(named, Sequence) or not named:
        raise ConfigError(f"learners={learners!r}: must be a number of robots, or a list of them")
    return sorted({_number_of(robot, agents) for robot in named})


def _number_of(robot: object, agents: Sequence[str]) -> int:
    if isinstance(robot, int) and not isinstance(robot, bool) and 0 <= robot < len(agents):
        return robot
    if isinstance(robot, str) and robot in agents:
        return agents.index(robot)
    raise ConfigError(
        f"learners: no robot {robot!r}; must be from {agents[0]} to {agents[-1]}, or its number"
    )
