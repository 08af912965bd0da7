"""A scenario of patrol, and the one that has a name."""

from pydantic import Field

from swarm_forage_env.parameters import BaseScenario, BaseTask, Count, NotNegative, Positive
from swarm_forage_env.registry import SCENARIOS


class PatrolTask(BaseTask):
    """The task: three places about the origin, to be visited in turn."""

    n_robots: Count = Field(4, description="Number of robots (chosen)")
    duration: Positive = Field(60.0, description="Length of an episode [s] (chosen)")
    distance: Positive = Field(0.3, description="Distance of a place from the origin [m] (chosen)")
    radius: Positive = Field(0.05, description="Distance at which a place is reached [m] (chosen)")


class PatrolScenario(BaseScenario):
    """Everything that fixes a world of patrol but its seed."""

    name: str = Field("custom", min_length=1, description="Name in tables and data")
    task: PatrolTask = PatrolTask()
    speed: Positive = Field(0.1, description="Wheel speed at full command [m/s] (chosen)")
    axle: Positive = Field(0.05, description="Distance between the wheels [m] (chosen)")
    noise: NotNegative = Field(0.02, description="Standard deviation of a reading [m] (chosen)")
    tick: Positive = Field(0.1, description="Control period [s] (chosen)")


SCENARIOS.register("patrol-1")(PatrolScenario(name="patrol-1"))
