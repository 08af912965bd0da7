"""Options of an environment: learned layer, reward, episode length."""

from typing import Annotated, Any

from pydantic import Field

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import Count, NotNegative, Part, Share


class EnvConfig(Part):
    """What is learned, for what reward, and how the world runs."""

    learn: str = Field("motion", description="Layer that the policy takes the place of")
    residual: bool = Field(
        False, description="Wheels of the policy are added to those of the hand-written motion"
    )
    reward: str = Field("own", description="Who is credited with a round trip")
    shaping: NotNegative = Field(0.0, description="Weight of the potential-based shaping; 0: none")
    discount: Share = Field(0.99, description="The learner's discount, for the shaping")
    decision_period: Count = Field(1, description="Ticks for which an action is held")
    physics: str | None = Field(
        None, description="Engine that moves the robots; none: the one its scenario goes with"
    )
    threads: Count = Field(1, description="Threads that the worlds are spread over")
    max_cycles: Annotated[int, Field(ge=1)] | None = Field(
        None, description="Decisions in an episode; none: as many as fit into the scenario's time"
    )


def n_steps(scenario: Any, config: EnvConfig) -> int:  # noqa: ANN401 of any task
    """Decisions in an episode: `max_cycles`, or as many as fit into the scenario's time."""
    if config.decision_period > scenario.n_ticks:
        raise ConfigError(
            f"decision_period={config.decision_period}: must be at most the"
            f" {scenario.n_ticks} ticks of an episode"
        )
    return config.max_cycles or scenario.n_ticks // config.decision_period
