"""Named scenarios: es1, es2, es3 and real (TR 6.1, 6.2), ants2008 (ANTS 4.1), and others.

Two are for first trainings, without errors of odometry and radio: near and es1-clean. Their
infrared and ground sensors are noisy, as robots without any noise may repeat a movement for ever.
Three have more than two areas, areas of different worth, or one that moves: twenty robots for half
an hour in an arena of 3 x 2 m, with the radio, sensors and robots of es1.

Not in the papers: the distance between the areas and where they lie, the cruise speed, the wheel
noise of the TR, the number of frames that an exchange averages, and its duration. The values are
starting points from the published counts of round trips; the description of each field gives its
origin.
"""

from swarm_forage_env.epuck.parts import Arena, Radio, Robot, Sensors
from swarm_forage_env.foraging.areas import Area
from swarm_forage_env.foraging.scenario import Scenario, Task
from swarm_forage_env.registry import ORIGINS, SCENARIOS


def enter(about: str, scenario: Scenario) -> None:
    """Register a scenario under its name."""
    SCENARIOS.register(scenario.name, about)(scenario)


enter("small arena of the report of 2009", Scenario(name="es1"))
enter(
    "middle arena of the report of 2009",
    Scenario(
        name="es2",
        arena=Arena(length=4.25, width=3.0),
        task=Task(n_robots=50, duration=7200.0, area_distance=2.8, start_radius=0.5),
    ),
)
enter(
    "large arena of the report of 2009",
    Scenario(
        name="es3",
        arena=Arena(length=8.5, width=6.0),
        task=Task(n_robots=100, duration=7200.0, area_distance=2.4, start_radius=0.5),
    ),
)

REAL = Radio(range_model="board", exchange_time=0.5, frames=1)
"""Radio of ten real e-pucks in the arena of es1. Communication takes 20-30 % longer (TR 6.2,
published); one of two messages gives a reading, and the wheels turn slower than simulated ones
(both derived: they fit the round trips and the share on the path of TR 6.2)."""

enter(
    "es1 with the radio and the pace of real e-pucks",
    Scenario(name="real", robot=Robot(cruise_speed=0.05), radio=REAL),
)

ANTS = Sensors(wheel_noise=0.063)
"""Wheel noise: +-20 % of the maximum path (ANTS 4.1) in a time step of 10 ms, which the paper does
not give, is +-6.3 % in 100 ms (derived)."""

enter(
    "world of the paper of 2008, with a longer radio range",
    Scenario(
        name="ants2008",
        arena=Arena(length=3.0, width=3.0),
        radio=Radio(max_range=0.25),
        sensors=ANTS,
        task=Task(
            n_robots=30, duration=3600.0, area_radius=0.2, area_distance=2.0, start_radius=0.5
        ),
    ),
)
ORIGINS["ants2008"] = {
    **dict.fromkeys(("arena.length", "arena.width", "radio.max_range"), "ANTS 4.1 (published)"),
    "task.n_robots": "ANTS Fig. 3a (published)",
    **dict.fromkeys(("task.duration", "task.area_radius"), "ANTS 4.1 (published)"),
    "task.start_radius": "ANTS 4.1 says in the centre (chosen)",
}

CLEAN_SENSORS = Sensors(wheel_noise=0.0)
CLEAN_RADIO = Radio(range_noise=0.0, bearing_noise=0.0, loss_near=0.0, loss_far=0.0)

enter(
    "es1 without errors of odometry and radio",
    Scenario(name="es1-clean", sensors=CLEAN_SENSORS, radio=CLEAN_RADIO),
)
enter(
    "quick to learn: few robots, no odometry error, a short way",
    Scenario(
        name="near",
        sensors=CLEAN_SENSORS,
        radio=CLEAN_RADIO,
        task=Task(n_robots=5, duration=300.0, area_distance=0.7),
    ),
)
for clean in ("es1-clean", "near"):
    ORIGINS[clean] = {
        f"{part}.{name}": "No error in this scenario (chosen)"
        for part, noises in (("sensors", CLEAN_SENSORS), ("radio", CLEAN_RADIO))
        for name in sorted(noises.model_fields_set)
    }
ORIGINS["near"] |= {
    "task.n_robots": "A small swarm (chosen)",
    "task.duration": "A short episode (chosen)",
    "task.area_distance": "As near as the start circle allows (chosen)",
}


def enter_with_areas(about: str, name: str, *areas: Area) -> None:
    """Register a scenario with these areas under a name."""
    arena, task = Arena(length=3.0, width=2.0), Task(n_robots=20, start_radius=0.25, areas=areas)
    enter(about, Scenario(name=name, arena=arena, task=task))
    ORIGINS[name] = {
        **dict.fromkeys(("arena.length", "arena.width"), "Room for the areas (chosen)"),
        "task.n_robots": "Twice those of es1 (chosen)",
        "task.start_radius": "Room for the robots (chosen)",
        "task.areas": "The subject of this scenario (chosen)",
    }


NEST = Area(kind="nest", centre=(-0.8, 0.0))

enter_with_areas(
    "a poor prey area near the nest, and a rich one farther away",
    "two-prey",
    *(NEST, Area(centre=(0.3, 0.75)), Area(centre=(1.2, -0.5), worth=3.0)),
)
enter_with_areas(
    "the prey area moves once, in mid-episode",  # a metre away, at the same distance from the nest
    "moving-prey",
    *(NEST, Area(centre=(0.7, 0.5), moves_at=900.0, moves_to=(0.7, -0.5))),
)
enter_with_areas(
    "two nests, equally far from the prey area",
    "two-nests",
    Area(kind="nest", centre=(-0.8, 0.6)),
    Area(kind="nest", centre=(-0.8, -0.6)),
    Area(centre=(0.7, 0.0)),
)
