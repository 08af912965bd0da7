"""Faults: which robots of a scenario fail, how, and from when; by default none.

Each kind of fault has its own random stream, which the seed of the world fixes. A larger share adds
robots to those that fail with a smaller share.

Sources of the kinds:
- WinfieldNembrini2006, Safety in numbers: fault-tolerance in robot swarms (IJMIC 1);
- CarlsonMurphy2005, How UGVs physically fail in the field (IEEE Trans. Robotics 21);
- Christensen2009, From fireflies to fault-tolerant swarms of robots (IEEE Trans. Evol. Comp. 13);
- BorensteinFeng1996, Measurement and correction of systematic odometry errors in mobile robots
  (IEEE Trans. Robotics and Automation 12);
- Strobel2018, Managing Byzantine robots via blockchain technology in a swarm robotics collective
  decision making scenario (AAMAS);
- VanCalck2023, A blockchain-based information market to incentivise cooperation in swarms of
  self-interested robots (Scientific Reports 13): foraging robots that sell false places;
- Ni2009, Sensor network data fault types (ACM Trans. Sensor Networks 5).

Not in the papers, and chosen here: every default, that a share is rounded to whole robots, and
that a robot may have several faults.
"""

import math
from typing import Literal

from pydantic import Field, field_validator, model_validator

from swarm_forage_env.parameters import NotNegative, Parameters, Share, list_as


class FaultKind(Parameters):
    """Robots that have a fault, and the time from which they have it."""

    share: Share = Field(
        0.0, description="Share of the robots with this fault, rounded to whole robots (chosen)"
    )
    robots: tuple[int, ...] = Field(
        (), description="Robots with this fault, by index, instead of a share (chosen)"
    )
    at: NotNegative = Field(0.0, description="Time at which the fault begins [s] (chosen)")

    @property
    def is_any(self) -> bool:
        """Whether any robot may have the fault."""
        return self.share > 0.0 or bool(self.robots)

    _from_text = field_validator("robots", mode="before")(list_as("[0, 3]"))

    @model_validator(mode="after")
    def _says_one(self) -> "FaultKind":
        if self.share > 0.0 and self.robots:
            kind = f"faults.{type(self).__name__.lower()}"
            raise ValueError(
                f"{kind}.share={self.share:g}, {kind}.robots={list(self.robots)}: give the faulty"
                " robots or their share, not both"
            )
        return self


class Dead(FaultKind):
    """Robot that stops for good and becomes an obstacle: motor failure.

    Source: WinfieldNembrini2006, hazards H1 (motors alone) and H6 (all systems); Christensen2009.
    """

    talks: bool = Field(
        True,
        description="Whether its radio still works, the worst case; false: it is silent, too."
        " WinfieldNembrini2006, H1 and H6 (published)",
    )


class Worn(FaultKind):
    """Robot with wrong odometry: unequally worn wheels and noisy encoders.

    Source: BorensteinFeng1996, unequal wheel diameters; CarlsonMurphy2005, effectors fail most.
    """

    bias: Share = Field(
        0.05,
        description="Share by which the encoder of one wheel reads too much and that of the"
        " other too little; which one is random. BorensteinFeng1996 gives the form; the size is"
        " chosen",
    )
    noise_factor: NotNegative = Field(
        5.0, description="Noise of its encoders, as a multiple of sensors.wheel_noise (chosen)"
    )


class Deaf(FaultKind):
    """Robot that receives no message. Source: WinfieldNembrini2006, hazard H2 (communications)."""


class Mute(FaultKind):
    """Robot that sends no message. Source: WinfieldNembrini2006, hazard H2 (communications)."""


class Blind(FaultKind):
    """Infrared that reads zero. Source: WinfieldNembrini2006, hazard H3 (avoidance sensors)."""


class Liar(FaultKind):
    """Robot that sends a false place of each area that it would send.

    Source: Strobel2018 (Byzantine robots); VanCalck2023 (false places among foraging robots).
    """

    turn: NotNegative = Field(
        math.pi,
        le=math.pi,
        description="Angle by which a reported place is turned about the liar [rad], to a random"
        " side. VanCalck2023 gives the form; the size is chosen",
    )
    shift: NotNegative = Field(
        0.0, description="Shift of a reported place [m], in a random direction (chosen)"
    )
    p: NotNegative = Field(
        0.0, description="Inverse confidence that it reports [m]; 0: complete confidence (chosen)"
    )
    own_p: bool = Field(False, description="Whether it reports its own p instead (chosen)")
    probability: Share = Field(
        1.0, description="Probability that a message is a lie; 1: every message (chosen)"
    )
    conspire: Literal["no", "turn", "place"] = Field(
        "no",
        description="Conspiracy of liars. no: each liar has a turn and shift of its own. turn:"
        " all turn and shift alike. place: all report one false place of each area, drawn in the"
        " arena at least half the areas' distance from the true one, and turn and shift have no"
        " effect (chosen)",
    )


class Stale(FaultKind):
    """Robot that repeats its first message after the fault: place and p, in its own frame.

    Source: Ni2009, stuck-at fault.
    """


class Faults(Parameters):
    """Faults of a scenario by kind, in the order of KINDS; none by default."""

    dead: Dead = Dead()
    worn: Worn = Worn()
    deaf: Deaf = Deaf()
    mute: Mute = Mute()
    blind: Blind = Blind()
    liar: Liar = Liar()
    stale: Stale = Stale()

    @property
    def is_any(self) -> bool:
        """Whether any robot may be faulty."""
        return any(kind.is_any for _, kind in self)

    def check_robots(self, n_robots: int) -> None:
        """Raise ValueError if a kind names a robot twice or one that the swarm does not have."""
        for name, kind in self:
            named = kind.robots
            if len(set(named)) < len(named) or not set(named) <= set(range(n_robots)):
                raise ValueError(
                    f"faults.{name}.robots={list(named)}: must be different numbers from 0 to"
                    f" {n_robots - 1}"
                )
