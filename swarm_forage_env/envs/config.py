"""Options of an environment: learned layer, action, observation, reward, episode length."""

from collections.abc import Callable, Mapping, Sequence
from numbers import Integral
from typing import Annotated, Literal

from pydantic import Field, ValidationError, field_validator

from swarm_forage_env import parameters
from swarm_forage_env.controllers import robot_number
from swarm_forage_env.errors import ConfigError, shown
from swarm_forage_env.parameters import Count, NotNegative, Parameters, Positive, Share

MAX_CHOICES = 4096
"""Maximum number of discrete actions of a robot; a network has one output for each."""

MAX_FRAMES = 1000
"""Maximum number of stacked observations; a network has one input for each of their features."""


class PolicyKeywords(Parameters):
    """Keywords of a policy: the layers it replaces, its observations and its actions."""

    learn: str = Field(
        "motion",
        description="Layers that the policy replaces: `weighting`, `motion`, `both` or"
        " `everything`",
    )
    residual: Share = Field(
        0.0,
        description="Gain of a residual policy: twice this share of its wheel speeds is added to"
        " those of the hand-written motion; true: 1; 0: the policy replaces the motion. For"
        " `motion` and `both`",
    )
    action: str | None = Field(
        None,
        description="Form of steering: `drive`, `course` or `wheels` (waypoints: `pull`); None:"
        " `drive`. A policy of `weighting` steers nothing",
    )
    reflexes: bool | None = Field(
        None,
        description="Whether the hand-written motion stops the robot during an exchange and"
        " avoids obstacles, in every tick, while the policy drives otherwise; false: the policy"
        " alone drives. None: true for `drive` and `course`",
    )
    walk: bool = Field(
        True,
        description="Whether a robot without a goal observes the direction of its random walk. For"
        " `motion` and `both`",
    )
    sharpest_turn: Annotated[Positive, Field(le=1.0)] = Field(
        0.3,
        description="Sharpest turn of `drive`, as a share of the largest difference between the"
        " wheels; no other action reads it",
    )
    discrete: bool | tuple[Count, Count] = Field(
        False,
        description="Discrete actions: true for the default choices, `(n, m)` for n speeds times"
        f" m turns; at most {MAX_CHOICES:,}",
    )
    observation: object = Field(
        "layer", description="Observation: a name, a class of your own, or a list of these"
    )
    normalise: bool = Field(
        True,
        description="Whether observations, state and weights lie in [-1, 1]; false: SI units,"
        " and weights in [0, 1]",
    )
    stack: Count = Field(
        1,
        description="Number of decisions whose observations are stacked, newest last; at most"
        f" {MAX_FRAMES:,}",
    )
    decision_period: Count | None = Field(
        None,
        description="Time for which an action is held and its rewards are summed [ticks]; None:"
        " 10 for `motion`, 5 for `everything`, else 1",
    )
    step_on: Literal["tick", "exchange"] = Field(
        "tick",
        description="Event that ends a step: `tick`, the end of a decision period; `exchange`,"
        " for `weighting`, an exchange of a learner",
    )

    @field_validator("discrete", mode="wrap")
    @classmethod
    def _as_choices(cls, discrete: object, check: Callable[[object], object]) -> object:
        try:
            return check(discrete)
        except ValidationError:
            raise ConfigError(
                f"discrete={shown(discrete)}: must be True, False, or (n, m) for n speeds times"
                " m turns; in the name of a policy, write nxm, as in 3x5"
            ) from None

    @field_validator("residual", mode="before")
    @classmethod
    def _as_share(cls, residual: object) -> object:
        return {"true": 1.0, "false": 0.0}.get(str(residual).lower(), residual)


class EnvConfig(PolicyKeywords):
    """Options of an environment: its policy, learners, reward, engine and episode length."""

    learners: object = Field(
        None,
        description="Robots that learn: how many, or a list of names or indices; None: all. The"
        " others keep the layers of `controller`",
    )
    reward: object = Field("own", description="Reward: `own`, `team`, or a callable")
    shaping: NotNegative = Field(
        0.0, description="Weight of the potential-based shaping; 0: no shaping"
    )
    discount: Share = Field(
        0.99, description="Discount of the learner for a step, which the shaping needs"
    )
    randomise: Mapping[str, object] = Field(
        default_factory=dict,
        description="Ranges from which scenario parameters are drawn for each episode:"
        ' `{"task.area_distance": (0.8, 1.5)}`',
    )
    physics: str | None = Field(
        None,
        description="Engine that moves the robots: `rigid` or `kinematic`; None: that of the"
        " scenario",
    )
    threads: Count = Field(
        1,
        description="Number of threads that run the worlds of a block; results do not depend on"
        " it. Faster with hundreds of worlds",
    )
    max_cycles: Annotated[int, Field(ge=1, le=parameters.MAX_TICKS)] | None = Field(
        None,
        description='Length of an episode [steps; with `step_on="exchange"` ticks]; None: the'
        " scenario's duration",
    )

    @field_validator("stack")
    @classmethod
    def _few_frames(cls, stack: int) -> int:
        if stack > MAX_FRAMES:
            raise ConfigError(
                f"stack={shown(stack)}: must be at most {MAX_FRAMES}, because a network has one"
                " input for each feature of each stacked observation; use a smaller stack, or a"
                " longer decision_period"
            )
        return stack

    @property
    def period(self) -> int:
        """Number of ticks for which an action is held; 1 if `decision_period` is None."""
        return self.decision_period or 1


def n_steps(scenario: parameters.BaseScenario, config: EnvConfig) -> int:
    """Return the decisions per episode: `max_cycles`, or as many as fit the scenario's duration."""
    if config.period > scenario.n_ticks:
        raise ConfigError(
            f"decision_period={shown(config.period)}: must be at most the {scenario.n_ticks} ticks"
            " of an episode"
        )
    return config.max_cycles or scenario.n_ticks // config.period


def chosen_robots(learners: object, agents: Sequence[str]) -> list[int]:
    """Return the sorted indices of the robots that learn; an error for an invalid selection.

    >>> chosen_robots(2, ["epuck_0", "epuck_1", "epuck_2"])
    [0, 1]
    >>> chosen_robots(["epuck_2", 0], ["epuck_0", "epuck_1", "epuck_2"])
    [0, 2]
    """
    if learners is None:
        return list(range(len(agents)))
    if type(learners) is not bool and isinstance(learners, Integral):
        if 1 <= int(learners) <= len(agents):
            return list(range(int(learners)))
        raise ConfigError(f"learners={shown(learners)}: must be from 1 to {len(agents)} robots")
    named = [learners] if isinstance(learners, str) else learners
    if not isinstance(named, Sequence) or not named:
        raise ConfigError(
            f"learners={shown(learners)}: must be the number of robots, or a list of their names or"
            " indices"
        )
    robots = [robot_number(robot, agents) for robot in named]
    if len(set(robots)) < len(robots):
        raise ConfigError(f"learners={shown(learners)}: a robot is named twice")
    return sorted(robots)
