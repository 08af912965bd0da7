"""What a learner agrees on with an environment: the layer, the reward, the time."""

from typing import Annotated

from pydantic import Field

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenario import Count, NotNegative, Part, Share
from swarm_forage_env.waypoints_scenario import AnyScenario


class Terms(Part):
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
    max_cycles: Annotated[int, Field(ge=1)] | None = Field(
        None, description="Decisions in an episode; none: as many as fit into the scenario's time"
    )


def cycles_of(scenario: AnyScenario, terms: Terms) -> int:
    """Decisions in an episode: `max_cycles`, or as many as fit into the scenario's time."""
    if terms.decision_period > scenario.n_ticks:
        raise ConfigError(
            f"decision_period={terms.decision_period}: must be at most the"
            f" {scenario.n_ticks} ticks of an episode"
        )
    return terms.max_cycles or scenario.n_ticks // terms.decision_period
