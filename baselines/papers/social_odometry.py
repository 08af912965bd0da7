"""Gutierrez et al. 2009 (TR): the claims and figures of Section 6.

Not in the paper, and chosen here:
- the eight values of beta "in [1e-5, 100]" are the decades;
- "SGIKF" and "SGIFF" without "single" or "double" mean the single one, which is the better one;
- NC makes 60 round trips in es1: the 150 of SGIKF are 2.5 times as many (TR 6.1.2);
- the best beta is scored on other seeds than those it was chosen on (`CrossValidatedBest`);
- "four times faster" is the ratio of mean recruitment times, all four strategies taken
  together; a run in which not all robots were recruited counts with its whole duration, so
  that the ratio is then a lower bound;
- "approximately in the same way": the mean recruitment time of each strategy is within 20 % (15 %
  in es1) of the mean of the four; "the same improvement" of the real robots: four times faster;
- "not all robots find the path" in es3: in at least 90 % of the runs;
- the share on the path is the mean over the second half of a run ("at steady state").
"""

from baselines.evaluation.line_plots import path_over_time
from baselines.papers.beta_sweep import (
    BETAS,
    BestBeta,
    BetaSweep,
    OptimumInsideRange,
    OtherBetasBelow,
)
from baselines.papers.claim_types import Claim, InRange, Order, below, number, share
from baselines.papers.experiments import (
    Experiment,
    Pool,
    Source,
    not_all_recruited,
    recruitment_time,
)
from baselines.papers.figures import Boxes, Curves, PaperFigure, recruitment_time_if_finished
from baselines.papers.paper import Paper

SETUPS = ("es1", "es2", "es3")
TOLERANCE = {"es1": 0.15, "es2": 0.20, "es3": 0.20, "real": 0.20}

TRIPS = {  # TR 6.1.2 and 6.2; NC is 150 / 2.5 in es1, and an upper bound in es2 and es3
    "es1": {"NC": 60.0, "SGIKF": 150.0, "SGIFF": 170.0},
    "es2": {"NC": 50.0, "SGIKF": 1400.0},
    "es3": {"NC": 50.0, "SGIKF": 2000.0},
}

PUBLISHED_BETA = {"es1": 1e-2, "es2": 1e-2, "es3": 1e-3}

REAL_BETA = "beta=0.01"  # the only one run on the real robots (TR 6.2)


def strategies(setup: str) -> dict[str, Source]:
    """Return the five strategies of a setup by name; SGIFF has its best beta."""
    plain = "nc", "ssgikf", "dsgikf"
    of: dict[str, Source] = {name.upper(): Experiment(setup, name) for name in plain}
    for name in ("ssgiff", "dsgiff"):
        real = Experiment(setup, f"{name}:{REAL_BETA}")
        of[name.upper()] = real if setup == "real" else BetaSweep(setup, name).best
    return of


def communicating(setup: str) -> tuple[Source, ...]:
    """Return the four strategies with communication of a setup."""
    return tuple(source for name, source in strategies(setup).items() if name != "NC")


def round_trip_claims(setup: str) -> list[Claim]:
    """Return the claims on round trips; that of NC alone is a number in es1, else a bound."""
    of, published, near = strategies(setup), TRIPS[setup], TOLERANCE[setup]
    if setup == "es1":
        alone: Claim = number("es1: round trips, NC", of["NC"], published["NC"], near)
    else:
        alone = below(f"{setup}: round trips, NC", of["NC"], published["NC"])
    claims = [alone, number(f"{setup}: round trips, SGIKF", of["SSGIKF"], published["SGIKF"], near)]
    if "SGIFF" in published:
        text = f"{setup}: round trips, SGIFF with the best beta"
        claims.append(number(text, of["SSGIFF"], published["SGIFF"], near))
    pairs = tuple((each, of["NC"]) for each in communicating(setup))
    return [*claims, Order(f"{setup}: each strategy with communication above NC", pairs)]


def filter_claims(setup: str) -> list[Claim]:
    """Return the claims on the better filter and the best beta."""
    of, sweep = strategies(setup), BetaSweep(setup)
    gain = ((of["SSGIFF"], of["SSGIKF"]),)
    return [
        Order(f"{setup}: best SGIFF above SGIKF", gain),
        OptimumInsideRange(f"{setup}: best beta inside the swept range", sweep),
        BestBeta(f"{setup}: best beta", sweep, PUBLISHED_BETA[setup]),
        OtherBetasBelow(f"{setup}: every other beta below SGIKF", sweep, of["SSGIKF"]),
        Order(f"{setup}: SSGIKF above DSGIKF", ((of["SSGIKF"], of["DSGIKF"]),)),
        Order(f"{setup}: SSGIFF above DSGIFF", ((of["SSGIFF"], of["DSGIFF"]),)),
    ]


def path_claims(setup: str) -> list[Claim]:
    """Return the claims on the share of robots on the path."""
    text, alone = f"{setup}: share on the path", (strategies(setup)["NC"],)
    return [
        share(f"{text}, with communication", communicating(setup), (0.5, 0.7)),
        share(f"{text}, NC", alone, (0.0, 0.2)),
    ]


def faster_recruitment(setup: str) -> Claim:
    """Return the claim that communication makes recruitment four times faster."""
    times = strategies(setup)["NC"], Pool(communicating(setup))
    text = f"{setup}: times faster recruitment with communication"
    return number(text, times, 4.0, TOLERANCE[setup], recruitment_time)


def similar_recruitment(setup: str) -> Claim:
    """Return the claim that the strategies with communication recruit at about the same speed."""
    four, near = communicating(setup), TOLERANCE[setup]
    ratios = tuple((each, Pool(four)) for each in four)
    text = f"{setup}: recruitment time of each strategy over the mean of the four"
    return InRange(text, ratios, 1.0, 1.0 - near, 1.0 + near, recruitment_time)


def recruitment_claims() -> list[Claim]:
    """Return the claims on faster recruitment with communication, and on es3 without it."""
    late = "es3: share of NC runs in which not all robots find the path within 7200 s"
    return [
        *map(similar_recruitment, SETUPS),
        *map(faster_recruitment, ("es1", "es2")),
        share(late, (Experiment("es3", "nc"),), (1.0, 1.0), not_all_recruited),
    ]


def real_claims() -> list[Claim]:
    """Return the claims on the real robots."""
    of, talking = strategies("real"), Pool(communicating("real"))
    return [
        number("real: round trips, SGIKF", of["SSGIKF"], 120.0, TOLERANCE["real"]),
        number("real: round trips, SGIFF", of["SSGIFF"], 140.0, TOLERANCE["real"]),
        number("real: round trips, times those of NC", (talking, of["NC"]), 2.0, TOLERANCE["real"]),
        faster_recruitment("real"),
        share("real: share on the path, with communication", (talking,), (0.5, 0.5)),
    ]


def box_panel(setup: str, names: tuple[str, ...]) -> dict[str, dict[str, Source]]:
    """Return a panel with a box for each strategy."""
    return {name: {"": strategies(setup)[name]} for name in names}


def beta_panel(setup: str) -> dict[str, dict[str, Source]]:
    """Return a panel with both filters at each beta."""
    filters = ("ssgiff", "dsgiff")
    return {
        f"{beta:g}": {name.upper(): BetaSweep(setup, name).at(beta) for name in filters}
        for beta in BETAS
    }


def figures() -> list[PaperFigure]:
    """Return TR Figures 13 to 19."""
    titles = {setup: f"({letter}) {setup}" for letter, setup in zip("abc", SETUPS, strict=True)}
    five = ("NC", "SSGIKF", "DSGIKF", "SSGIFF", "DSGIFF")
    recruited = "Time until all robots have visited both areas; n: runs in which all did."
    trips, time = ("", "round trips"), ("", "time [s]")
    over_beta = ("beta [1/cm]", "round trips")
    path = ("time [s]", "robots on the path [%]")

    simulated = {titles[setup]: box_panel(setup, five) for setup in SETUPS}
    without_fermi = {titles[setup]: box_panel(setup, five[:3]) for setup in SETUPS}
    betas = {titles[setup]: beta_panel(setup) for setup in SETUPS}
    over_time = {titles[setup]: strategies(setup) for setup in SETUPS}
    real = {"real": box_panel("real", five)}
    real_over_time = {"real": strategies("real")}
    finished = recruitment_time_if_finished
    return [
        Boxes("tr13", f"TR Fig. 13. {recruited}", time, simulated, finished),
        Boxes("tr14", "TR Fig. 14. Round trips of NC and SGIKF.", trips, without_fermi),
        Boxes("tr15", "TR Fig. 15. Round trips of SGIFF over beta.", over_beta, betas),
        Curves("tr16", "TR Fig. 16. Robots on the path.", path, over_time, path_over_time),
        Boxes("tr17", f"TR Fig. 17. {recruited}", time, real, finished),
        Boxes("tr18", "TR Fig. 18. Round trips.", trips, real),
        Curves("tr19", "TR Fig. 19. Robots on the path.", path, real_over_time, path_over_time),
    ]


LEFT_OPEN = {
    "The setups": "swarm_forage_env.foraging.named",
    "Sensors, wheels and radio": "swarm_forage_env.epuck.parts",
    "Exchanging, trusting and losing estimates": "baselines.estimators.social_odometry",
    "Moving": "baselines.motion.subsumption",
    "The Fermi filter": "baselines.weighting.sgiff:SGIFF",
    "The experiments": "baselines.papers.social_odometry",
}


CLAIMS = (
    *(claim for setup in SETUPS for claim in round_trip_claims(setup)),
    *(claim for setup in SETUPS for claim in filter_claims(setup)),
    *recruitment_claims(),
    *(claim for setup in SETUPS for claim in path_claims(setup)),
    *real_claims(),
)

PAPER = Paper("social-odometry", CLAIMS, tuple(figures()), 30, LEFT_OPEN)
"""TR: every claim and figure of Section 6."""
