"""Gutierrez et al. 2008 (ANTS): the claims and figures of Section 5.

Not in the paper, and chosen here:
- the robots and their sensors are those of the TR, with errors of the encoders of +-20 % in time
  steps of 10 ms; they start within 0.5 m of the centre, and the areas lie 2 m apart;
- the epsilon of Eq. 3 is the distance travelled, as in the TR: were it the inverse of it, as the
  text says, the worse estimate would weigh more;
- the group sizes; 30 robots for Figures 2a and 2b;
- "local communication" is the single Fermi filter with the published beta of 1e-3;
- "covariance knowledge" tells whole error ellipses (`covariance`): 727 (718 to 733) round trips.
  Robots that tell their norm (`sikf`) make 770 (765 to 776), local communication 838 (832 to 844),
  by `swarm-forage evaluate ants2008 ssgiff:beta=0.001 covariance sikf --physics kinematic
  --episodes 20`;
- "not significantly different" is a Mann-Whitney p of at least 0.05;
- "few robots" is the smallest group, "many" are the groups of 30 and more;
- how fast the gain rises is the slope of local communication's round trips over the group
  size, seed by seed: up to 10 robots, and from 10 on;
- Figure 3a has two readings: the time until all robots of a group have visited both areas,
  over the size of the group, and the time of the k-th robot of 30. Both are drawn.
"""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from baselines.papers.beta_sweep import BETAS, BestBeta, BetaSweep
from baselines.papers.claim_types import Claim, Contrast, NoDifference, Order
from baselines.papers.experiments import Experiment, Results, recruitment_time, round_trips, sample
from baselines.papers.figures import Boxes, Curves, PaperFigure, time_of_each_robot
from baselines.papers.paper import Paper
from baselines.papers.social_odometry import LEFT_OPEN as TR_LEFT_OPEN

SCENARIO = "ants2008"
PUBLISHED_BETA = 1e-3
LOCAL = f"ssgiff:beta={PUBLISHED_BETA:g}"

SIZES = (2, 5, 10, 15, 20, 30, 40, 50)  # robots in a group

BEND, FEW, MANY = 10, SIZES[0], 30
"""Size from which the gain rises more slowly; size of few robots; least size of many robots."""

CONTROLLERS = {  # by their names in ANTS 5
    "no communication": "nc",
    "no odometry error": "no-error",
    "covariance knowledge": "covariance",
    "global communication": "global",
    "local communication": LOCAL,
}


def experiment_of_size(controller: str, size: int) -> Experiment:
    """Return the experiment of a controller with a group of `size` robots."""
    return Experiment(SCENARIO, controller, (f"task.n_robots={size}",))


def slope(results: Results, sizes: Sequence[int]) -> list[float]:
    """Return the round trips gained per added robot for each seed, by a linear fit over sizes."""
    trips = [sample(results, experiment_of_size(LOCAL, size), round_trips) for size in sizes]
    return [float(each) for each in np.polyfit(sizes, np.array(trips), 1)[0]]


def slopes(results: Results) -> tuple[list[float], list[float]]:
    """Return the round trips gained per robot for each seed, below the bend and above it."""
    bend = SIZES.index(BEND)
    return slope(results, SIZES[: bend + 1]), slope(results, SIZES[bend:])


def claims() -> list[Claim]:
    """Return every claim of ANTS 5."""
    local = Experiment(SCENARIO, LOCAL)
    at_size = partial(experiment_of_size, LOCAL)
    perfect = tuple((experiment_of_size("no-error", size), at_size(size)) for size in SIZES)
    silent = tuple((at_size(size), experiment_of_size("nc", size)) for size in SIZES)
    slower = tuple((experiment_of_size("nc", n), at_size(n)) for n in SIZES if n >= MANY)
    growing = tuple(experiment_of_size(LOCAL, size) for size in SIZES)
    return [
        BestBeta("ants2008: best beta", BetaSweep(SCENARIO), PUBLISHED_BETA),
        Order("ants2008: no odometry error above local, at every group size", perfect),
        Order("ants2008: local above no communication, at every group size", silent),
        NoDifference(
            "ants2008: local and covariance knowledge do not differ significantly",
            local,
            Experiment(SCENARIO, "covariance"),
        ),
        Order("ants2008: local above global", ((local, Experiment(SCENARIO, "global")),)),
        Contrast(
            f"ants2008: local gains more a robot below {BEND} robots than above", growing, slopes
        ),
        NoDifference(
            f"ants2008: recruitment of {FEW} robots does not differ with communication",
            experiment_of_size("nc", FEW),
            at_size(FEW),
            recruitment_time,
        ),
        Order(
            f"ants2008: recruitment of {MANY} and more robots faster with communication",
            slower,
            recruitment_time,
        ),
    ]


def figures() -> list[PaperFigure]:
    """Return ANTS Figures 2a, 2b, 3a in both readings, and 3b."""
    two = "no communication", "local communication"
    three = "no odometry error", "local communication", "no communication"

    def over_size(names: Sequence[str]) -> Mapping[str, Mapping[str, Mapping[str, Experiment]]]:
        of = {name: CONTROLLERS[name] for name in names}
        return {SCENARIO: {
            str(size): {name: experiment_of_size(each, size) for name, each in of.items()}
            for size in SIZES
        }}  # fmt: skip

    betas = {f"{beta:g}": {"": BetaSweep(SCENARIO).at(beta)} for beta in BETAS}
    of_30 = {name: Experiment(SCENARIO, controller) for name, controller in CONTROLLERS.items()}
    behaviours = {name: {"": each} for name, each in of_30.items()}
    each = {SCENARIO: {name: of_30[name] for name in two}}
    late = "A run in which not all did counts with its whole duration."
    return [
        Boxes("ants2a", "ANTS Fig. 2a. Round trips of local communication over beta.",
              ("beta [1/cm]", "round trips"), {SCENARIO: betas}),
        Boxes("ants2b", "ANTS Fig. 2b. Round trips of 30 robots.", ("", "round trips"),
              {SCENARIO: behaviours}),
        Boxes("ants3a", "ANTS Fig. 3a, read over the group size. Time until all robots have"
              f" visited both areas. {late}", ("robots", "time [s]"), over_size(two),
              recruitment_time),
        Curves("ants3a_each", "ANTS Fig. 3a, read robot by robot. Time until k of 30 robots have"
               f" visited both areas. {late}", ("k", "time [s]"), each, time_of_each_robot),
        Boxes("ants3b", "ANTS Fig. 3b. Round trips over the group size.",
              ("robots", "round trips"), over_size(three)),
    ]  # fmt: skip


LEFT_OPEN = {**TR_LEFT_OPEN, "The experiments": "baselines.papers.ants2008"}

PAPER = Paper("ants2008", tuple(claims()), tuple(figures()), 30, LEFT_OPEN)
"""ANTS: every claim and figure of Section 5."""
