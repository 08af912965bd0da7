"""The setups of the papers: es1, es2, es3 and real (TR 6.1, 6.2), and ants2008 (ANTS 4.1).

And two in which odometry and radio do not err, to start to learn in: near, and es1-clean. The
infrared and ground sensors do: where nothing is left to chance, robots may repeat themselves for
ever. And three with more than two areas, of differing worth, or with one that moves: twenty robots
for half an hour in an arena of 3 x 2 m, with radio, sensors and robots of es1.

Not in the papers: the distance between the areas, the cruise speed, the wheel noise of the TR,
how many frames an exchange averages and how long it takes. The values are starting points
from the published counts of round trips; each field's description says its origin.
"""

from swarm_forage_env.epuck.parts import Arena, Radio, Robot, Sensors
from swarm_forage_env.foraging.areas import Area
from swarm_forage_env.foraging.scenario import Scenario, Task
from swarm_forage_env.registry import ORIGINS, SCENARIOS

ES1 = Scenario(name="es1")

ES2 = Scenario(
    name="es2",
    arena=Arena(length=4.25, width=3.0),
    task=Task(n_robots=50, duration=7200.0, area_distance=2.8, start_radius=0.5),
)

ES3 = Scenario(
    name="es3",
    arena=Arena(length=8.5, width=6.0),
    task=Task(n_robots=100, duration=7200.0, area_distance=2.4, start_radius=0.5),
)

REAL = Scenario(
    name="real",
    robot=Robot(cruise_speed=0.05),
    radio=Radio(range_model="board", exchange_time=0.5, frames=1),
)
"""Ten real e-pucks in the arena of es1. Communication takes 20-30 % longer (TR 6.2, published);
one message of two is good for a reading, and the wheels turn slower than simulated ones (both
derived: they fit the round trips and the share on the path of TR 6.2)."""

ANTS2008 = Scenario(
    name="ants2008",
    arena=Arena(length=3.0, width=3.0),
    radio=Radio(max_range=0.25),
    sensors=Sensors(wheel_noise=0.063),
    task=Task(n_robots=30, duration=3600.0, area_radius=0.2, area_distance=2.0, start_radius=0.5),
)
"""+-20 % of the maximum movement in a step of 10 ms (ANTS 4.1) is +-6.3 % at 100 ms (derived)."""

ORIGINS["ants2008"] = {
    "arena.length": "ANTS 4.1 (published)",
    "arena.width": "ANTS 4.1 (published)",
    "radio.max_range": "ANTS 4.1 (published)",
    "task.n_robots": "ANTS Fig. 3a (published)",
    "task.duration": "ANTS 4.1 (published)",
    "task.area_radius": "ANTS 4.1 (published)",
    "task.start_radius": "ANTS 4.1 says in the centre (chosen)",
}

CLEAN_SENSORS = Sensors(wheel_noise=0.0)

CLEAN_RADIO = Radio(range_noise=0.0, bearing_noise=0.0, loss_near=0.0, loss_far=0.0)

ES1_CLEAN = Scenario(name="es1-clean", sensors=CLEAN_SENSORS, radio=CLEAN_RADIO)
"""es1 in which nobody drifts, and nothing is misheard or lost."""

NEAR = Scenario(
    name="near",
    sensors=CLEAN_SENSORS,
    radio=CLEAN_RADIO,
    task=Task(n_robots=5, duration=300.0, area_distance=0.7),
)
"""Five robots that do not drift, five minutes, areas half as far apart: soon learned."""

for clean in (ES1_CLEAN, NEAR):
    zero = {
        f"{part}.{name}": "None here (chosen)"
        for part, noises in (("sensors", CLEAN_SENSORS), ("radio", CLEAN_RADIO))
        for name in sorted(noises.model_fields_set)
    }
    ORIGINS[clean.name] = zero
ORIGINS["near"] |= {
    "task.n_robots": "A small swarm (chosen)",
    "task.duration": "A short episode (chosen)",
    "task.area_distance": "Near, beside the circle of the start (chosen)",
}

NEST = Area(kind="nest", centre=(-0.8, 0.0))


def with_areas(name: str, *areas: Area) -> Scenario:
    """The scenario of that name with these areas."""
    return Scenario(
        name=name,
        arena=Arena(length=3.0, width=2.0),
        task=Task(n_robots=20, start_radius=0.25, areas=areas),
    )


TWO_PREY = with_areas(
    "two-prey", NEST, Area(centre=(0.3, 0.75)), Area(centre=(1.2, -0.5), worth=3.0)
)
"""A poor prey area near the nest, and a rich one farther away."""

MOVING_PREY = with_areas(
    "moving-prey", NEST, Area(centre=(0.7, 0.5), moves_at=900.0, moves_to=(0.7, -0.5))
)
"""After a quarter of an hour the prey area lies a metre from where it was, as far from the nest."""

TWO_NESTS = with_areas(
    "two-nests",
    Area(kind="nest", centre=(-0.8, 0.6)),
    Area(kind="nest", centre=(-0.8, -0.6)),
    Area(centre=(0.7, 0.0)),
)
"""Two nests, equally far from the prey area."""

ABOUT = {
    "es1": "small arena of the report of 2009",
    "es2": "middle arena of the report of 2009",
    "es3": "large arena of the report of 2009",
    "real": "es1 with the radio and the pace of real e-pucks",
    "ants2008": "world of the first paper, in which the radio reaches farther",
    "es1-clean": "es1 without errors of odometry and radio",
    "near": "soon learned: few robots that do not drift, and a short way",
    "two-prey": "a poor prey area near the nest, and a rich one farther away",
    "moving-prey": "the prey area moves once, in mid-episode",
    "two-nests": "two nests, equally far from the prey area",
}
"""What each scenario is, in words."""

for scenario in (TWO_PREY, MOVING_PREY, TWO_NESTS):
    ORIGINS[scenario.name] = {
        **dict.fromkeys(("arena.length", "arena.width"), "Room for the areas (chosen)"),
        "task.n_robots": "Twice those of es1 (chosen)",
        "task.start_radius": "Room for the robots (chosen)",
        "task.areas": "What the scenario is about (chosen)",
    }

PAPERS = ES1, ES2, ES3, REAL, ANTS2008
for scenario in (*PAPERS, ES1_CLEAN, NEAR, TWO_PREY, MOVING_PREY, TWO_NESTS):
    SCENARIOS.register(scenario.name, ABOUT[scenario.name])(scenario)
