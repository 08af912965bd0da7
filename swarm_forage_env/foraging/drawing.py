"""What is drawn of a foraging world: its stage, and a scene for each tick."""

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Int8
from swarm_forage_env.epuck.drawing import bodies, walls
from swarm_forage_env.foraging.areas import KINDS, move_tick
from swarm_forage_env.foraging.metrics import believed_places, knows_both_areas_now
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.scoring import TO_NEST, TO_PREY
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.raw_control import has_estimators
from swarm_forage_env.record import Rows, rows
from swarm_forage_env.scene import EXPLORING, LOST, TALKING, TO_THE_NEST, TO_THE_PREY, Scene, Stage


def stage_of(scenario: Scenario, controller: str) -> Stage:
    """The stage of a scenario, moved by what is named so."""
    return Stage(
        controller=controller,
        areas=np.array([area.centre for area in scenario.places]),
        kinds=tuple(KINDS.index(area.kind) for area in scenario.places),
        names=tuple(
            area.kind if area.worth == 1.0 else f"{area.kind} x{area.worth:g}"
            for area in scenario.places
        ),
        moves=tuple(
            (k, move_tick(area.moves_at, scenario.tick) * scenario.tick, *area.moves_to)
            for k, area in enumerate(scenario.places)
            if area.moves_at is not None and area.moves_to is not None
        ),
        area_radius=scenario.task.area_radius,
        **walls(scenario),
    )


def scene_of(world: ForagingWorld, minds: Array, which: int = 0) -> Scene:
    """One world of a block as it stands; without beliefs where no estimator keeps any."""
    robots, n = world.robots[which].view(np.recarray), world.n_robots
    known, p = np.zeros((n, 2), np.bool_), np.zeros((n, 2), np.float32)
    believed, situations = np.zeros((n, 2, 2)), None
    if has_estimators(minds):
        situations = rows(minds["estimator"]["situation"][which])
        known, p = situations.known != 0, situations.p.copy()
        believed = believed_places(robots.pose, situations.areas, known)
    return Scene(
        doing=_doing(robots, situations),
        believed=believed,
        known=known,
        p=p,
        round_trips=robots.round_trips.copy(),
        on_path=float(knows_both_areas_now(robots.known, 1)[0]),
        **bodies(world, which),
    )


def _doing(robots: Rows, situations: Rows | None) -> Int8[Array, " robots"]:
    """The code of what each robot is doing; the last that holds counts."""
    doing = np.full(len(robots), EXPLORING, np.int8)
    if situations is None:
        doing[robots.leg == TO_NEST] = TO_THE_NEST
        doing[robots.leg == TO_PREY] = TO_THE_PREY
        return doing
    astray = (robots.lost_events > 0) & ~robots.known.any(axis=1)
    doing[astray & (situations.goal[:, 2] > 0)] = LOST
    doing[situations.goal[:, NEST] > 0] = TO_THE_NEST
    doing[situations.goal[:, PREY] > 0] = TO_THE_PREY
    doing[situations.is_talking > 0] = TALKING
    return doing
