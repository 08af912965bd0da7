"""Types of the environment keywords, for editors and type checkers.

`EnvConfig` validates the same keywords at run time. It also accepts names that other packages have
registered; mark them for a type checker with `learn=OwnName("cleaning")`. All scenario parameters
are keywords at run time, too; for type checkers, change the others with `find_scenario`:

    parallel_env(find_scenario("es1", {"radio.max_range": 0.2}), learn="weighting")
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NewType, TypedDict

from swarm_forage_env.controllers import Controllers
from swarm_forage_env.envs.extra_observations import Observation
from swarm_forage_env.scenarios import ScenarioSource

OwnName = NewType("OwnName", str)
"""Name that another package has registered or an older release used."""

Learn = Literal["motion", "weighting", "both", "everything"] | OwnName
Action = Literal["drive", "course", "wheels", "pull", "drive-v1"] | OwnName
Observed = (
    Literal["layer", "previous_action", "time_left", "robot_id", "one_hot"]
    | OwnName
    | type[Observation]
    | Observation
)
Physics = Literal["rigid", "kinematic"] | OwnName
Reward = Literal["own", "team"] | Callable[..., object]
RenderMode = Literal["human", "rgb_array", "ansi"]


class PolicyOptions(TypedDict, total=False):
    """Keywords of the observation and action of a policy: `PolicyKeywords` without `learn`."""

    residual: float
    action: Action | None
    reflexes: bool | None
    walk: bool
    sharpest_turn: float
    discrete: bool | tuple[int, int]
    observation: Observed | Sequence[Observed]
    normalise: bool
    stack: int
    decision_period: int | None
    step_on: Literal["tick", "exchange"]


class OtherOptions(PolicyOptions, total=False):
    """Fields of `EnvConfig` except `learn`, and the parameters that every scenario has."""

    learners: int | str | Sequence[int | str] | None
    reward: Reward
    shaping: float
    discount: float
    randomise: Mapping[str, Sequence[float]]
    physics: Physics | None
    threads: int
    max_cycles: int | None
    n_robots: int
    duration: float
    tick: float


class EnvOptions(OtherOptions, total=False):
    """Fields of `EnvConfig`, and the parameters that every scenario has."""

    learn: Learn


class SingleEnvOptions(EnvOptions, total=False):
    """All keywords of `parallel_env` and of the environments for Gymnasium and RLlib.

    For calls that accept any keyword: `gymnasium.make(id, **SingleEnvOptions(learn="weighting"))`.
    """

    scenario: ScenarioSource
    controller: Controllers | None
    render_mode: RenderMode | None
