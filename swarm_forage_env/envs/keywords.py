"""Keywords of environments for editors and type checkers, which refuse one that is misspelt.

`EnvConfig` validates the same keywords at run time, and takes names that packages of the user's own
have registered: `learn=OwnName("cleaning")` says so to a type checker. Numbers of a scenario
beside those here are keywords at run time too; `find_scenario` changes them under type checkers:

    parallel_env(find_scenario("es1", {"radio.max_range": 0.2}), learn="weighting")
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NewType, TypedDict

from swarm_forage_env.controllers import Controllers
from swarm_forage_env.envs.extra_observations import Observation
from swarm_forage_env.scenarios import ScenarioSource

OwnName = NewType("OwnName", str)
"""A name that a package of the user's own has registered, or an older release had."""

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
    """What a policy observes, and how its actions are read: `PolicyKeywords` but `learn`."""

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


class OtherOptions(PolicyOptions, total=False):
    """The fields of `EnvConfig` but `learn`, and the numbers that every scenario has."""

    learners: int | str | Sequence[int | str] | None
    reward: Reward
    shaping: float
    discount: float
    step_on: Literal["tick", "exchange"]
    randomise: Mapping[str, Sequence[float]]
    physics: Physics | None
    threads: int
    max_cycles: int | None
    n_robots: int
    duration: float
    tick: float


class EnvOptions(OtherOptions, total=False):
    """The fields of `EnvConfig`, and the numbers that every scenario has."""

    learn: Learn


class SingleEnvOptions(EnvOptions, total=False):
    """All keywords of `parallel_env`, of the environments of Gymnasium and of RLlib.

    For calls that take any keyword: `gymnasium.make(id, **SingleEnvOptions(learn="weighting"))`.
    """

    scenario: ScenarioSource
    controller: Controllers | None
    render_mode: RenderMode | None
