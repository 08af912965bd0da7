"""All that a controller may know and say: readings in, command out, and the layers between.

Every number that crosses a layer's border is float32 in SI units, the same number that the
environment shows in its observation: so a policy in the place of a layer sees exactly what
the hand-written layer sees.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, Int32, checked

WORDS = 12
"""Numbers in a message."""


@checked
@dataclass(frozen=True, slots=True)
class Readings:
    """What the robot's own sensors say after a tick."""

    proximity: Float32[Array, "rows 8"]
    """Infrared, 1 at contact and 0 beyond 5 cm, at PROXIMITY_ANGLES of the body frame."""

    ground: Float32[Array, "rows 3"]
    """Brightness under the left, middle and right ground sensor: nest 0, prey 0.5, floor 1."""

    odometry: Float32[Array, "rows 2"]
    """Distance [m] and turn [rad] since the last tick, as the wheel encoders tell them."""


@checked
@dataclass(frozen=True, slots=True)
class Heard:
    """The messages of one tick. An empty slot holds zeros and is not valid."""

    valid: Bool[Array, "rows slots"]
    """The slot holds a message."""

    sender: Int32[Array, "rows slots"]
    """Which robot of the same world sent it: 0 .. N - 1."""

    words: Float32[Array, "rows slots words"]
    """What the sender said; its meaning is the controller's."""

    beam: Float32[Array, "rows slots beam"]
    """The beam to the sender as measured: its length [m], the direction of the sender in the
    body frame of the receiver [rad], and the direction of the receiver in the body frame of
    the sender [rad]."""

    frames: Int32[Array, "rows slots"]
    """Frames averaged into the beam: several while the receiver stands still."""


@checked
@dataclass(frozen=True, slots=True)
class Feedback:
    """What comes back from a tick of the world."""

    readings: Readings
    heard: Heard
    reward: Float32[Array, " rows"]
    """Round trips completed in this tick."""
    done: Bool[Array, " worlds"]
    """The episode of this world is over."""


@checked
@dataclass(frozen=True, slots=True)
class Command:
    """What a controller tells the robots to do in the next tick."""

    wheels: Float64[Array, "rows 2"]
    """Speed of the left and right wheel [m/s]; the motors reach robot.max_speed at most."""

    words: Float32[Array, "rows words"]
    """What to broadcast."""

    speaking: Bool[Array, " rows"]
    """Broadcast at all."""

    lost: Bool[Array, " rows"]
    """Reported to the experimenter, not to the swarm: the robot just found itself lost."""

    known: Bool[Array, "rows areas"]
    """Reported likewise: the robot believes it knows where the area is."""


@checked
@dataclass(frozen=True, slots=True)
class Encounter:
    """What the weighting layer sees: one finished exchange for each row where it is valid."""

    valid: Bool[Array, " rows"]
    """An exchange ended in this tick."""

    own_p: Float32[Array, "rows areas"]
    """Own inverse confidence: path since leaving the area [m]."""

    heard_p: Float32[Array, "rows areas"]
    """The partner's inverse confidence [m]."""

    own_known: Bool[Array, "rows areas"]
    """The robot knows where the area is."""

    heard_known: Bool[Array, "rows areas"]
    """The partner told where the area is."""

    disagreement: Float32[Array, "rows areas"]
    """Distance between the own and the heard location, where both are known [m]."""

    own_distance: Float32[Array, "rows areas"]
    """How far the robot is from the own location [m]; zero where unknown."""

    heard_distance: Float32[Array, "rows areas"]
    """How far the robot is from the heard location [m]; zero where unknown."""

    range: Float32[Array, " rows"]
    """Distance to the partner, averaged [m]."""

    frames: Float32[Array, " rows"]
    """Readings averaged in this exchange."""

    goal: Int8[Array, " rows"]
    """The area the robot is heading for: 0 nest, 1 prey, -1 none."""


@checked
@dataclass(frozen=True, slots=True)
class Situation:
    """What the motion layer sees."""

    proximity: Float32[Array, "rows 8"]
    """As in Readings."""

    ground: Float32[Array, "rows 3"]
    """As in Readings."""

    target: Float32[Array, "rows 2"]
    """Where to go, body frame [m]; zeros without a goal."""

    areas: Float32[Array, "rows areas 2"]
    """Believed centres of nest and prey, body frame [m]; zeros where unknown."""

    p: Float32[Array, "rows areas"]
    """Own inverse confidence [m]; zeros where unknown."""

    known: Bool[Array, "rows areas"]
    """The robot believes it knows where the area is."""

    goal: Int8[Array, " rows"]
    """The area the robot is heading for: 0 nest, 1 prey, -1 none."""

    talking: Bool[Array, " rows"]
    """An exchange is under way: standing still makes its readings better."""

    heard: Bool[Array, "rows slots"]
    """The slot holds a message."""

    beam: Float32[Array, "rows slots beam"]
    """Where its sender is: as in Heard."""

    wheels: Float32[Array, "rows 2"]
    """The last command to the left and right wheel, as shares of the cruise speed."""


class Weighting(Protocol):
    """The confidence weighting: how much of what is heard enters the own estimate."""

    heard_p_share: float
    """Part that the heard p plays in the merged p: p = (1 - g) p_i + share g p_j."""

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """g in [0, 1] for each area, 0 keeping the own estimate and 1 taking the heard one."""
        ...


class Motion(Protocol):
    """The motion of W worlds of robots, with what it remembers between ticks."""

    def __call__(self, situation: Situation) -> Float32[Array, "rows 2"]:
        """Speed of the left and right wheel, in [-1, 1] of the cruise speed."""
        ...

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world, and draw from this seed from now on."""
        ...


class Estimator(Protocol):
    """Where the areas are, for W worlds of robots."""

    def observe(self, readings: Readings, heard: Heard, wheels: Float32[Array, "rows 2"]) -> None:
        """Take in one tick; then `encounter` and `situation` describe it."""
        ...

    encounter: Encounter
    situation: Situation

    def merge(self, g: Float32[Array, "rows areas"], heard_p_share: float) -> None:
        """Blend what the finished exchanges brought, with weight g."""
        ...

    def say(
        self,
    ) -> tuple[Float32[Array, "rows words"], Bool[Array, " rows"], Bool[Array, " rows"]]:
        """The words to broadcast, who broadcasts, and who just got lost."""
        ...

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        ...


class Controller(Protocol):
    """An estimator, a weighting and a motion, run on all rows of a block."""

    estimator: Estimator
    weighting: Weighting
    motion: Motion

    def observe(self, feedback: Feedback) -> None:
        """Take in what the world gave back; the layers' inputs are ready afterwards."""
        ...

    def command(
        self,
        g: Float32[Array, "rows areas"] | None = None,
        wheels: Float32[Array, "rows 2"] | None = None,
    ) -> Command:
        """The next command; a weight or wheels from outside take the place of that layer."""
        ...

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        ...


class ControllerRecipe(Protocol):
    """A named controller with its parameters, before it meets a world."""

    def build(self, scenario: Any, seeds: Sequence[int]) -> Controller:  # noqa: ANN401 either world
        """The running controller for a block of worlds, one for each seed."""
        ...

    def with_parameters(self, values: dict[str, Any]) -> "ControllerRecipe":
        """The same recipe with some parameters changed."""
        ...
