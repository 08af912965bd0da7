"""The control loop: tick, listen, then weigh and steer, merge, and tick again.

    world.tick(command) -> controller.observe(feedback) -> controller.command(g, wheels) -> ...

Between `observe` and `command` lies the cut where a policy takes the place of a layer.
"""

from collections.abc import Sequence
from typing import Any, Generic, TypeVar, cast

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.ground_truth import GroundTruth, is_reference, read_only
from swarm_forage_env.interface import Controller, ControllerRecipe
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.waypoints_scenario import AnyScenario, WaypointsScenario
from swarm_forage_env.waypoints_world import PHYSICS, WaypointsWorld
from swarm_forage_env.world import World

WorldT = TypeVar("WorldT", World, WaypointsWorld)


class Loop(Generic[WorldT]):
    """A block of worlds and the controller of all their robots, in turn."""

    def __init__(self, world: WorldT, controller: Controller) -> None:
        """Worlds that have been sensed and are about to move."""
        self.world: WorldT = world
        self.controller = controller
        self.controller.observe(cast(Any, world.feedback))

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        feedback = self.world.reset(seeds)
        for world, seed in enumerate(seeds):
            self.controller.reset(world, seed)
        self.controller.observe(cast(Any, feedback))

    def step(
        self,
        g: Float32[Array, "rows weights"] | None = None,
        wheels: Float32[Array, "rows 2"] | None = None,
    ) -> Any:  # noqa: ANN401 the feedback of its world
        """One tick; a weight g in [0, 1] or wheels in [-1, 1] replace that layer's own.

        Afterwards `controller.estimator.encounter` and `.situation` hold what either layer
        is shown next.
        """
        feedback = self.world.tick(cast(Any, self.controller.command(g, wheels)))
        self.controller.observe(cast(Any, feedback))
        return feedback


class ControlLoop(Loop[World]):
    """The loop of robots that forage."""

    def __init__(
        self,
        scenario: Scenario,
        recipe: ControllerRecipe,
        seeds: Sequence[int],
        physics: str = "rigid",
    ) -> None:
        """One world for each seed, sensed and about to move."""
        world = World(scenario, seeds, physics)
        super().__init__(world, _controller(recipe, world, seeds))


class WaypointsLoop(Loop[WaypointsWorld]):
    """The loop of robots that visit waypoints."""

    def __init__(
        self,
        scenario: WaypointsScenario,
        recipe: ControllerRecipe,
        seeds: Sequence[int],
        physics: str = PHYSICS,
    ) -> None:
        """One world for each seed, sensed and about to move."""
        world = WaypointsWorld(scenario, seeds, physics)
        super().__init__(world, recipe.build(scenario, seeds))


def default_physics(scenario: AnyScenario) -> str:
    """The engine of a scenario for which none is asked."""
    return PHYSICS if isinstance(scenario, WaypointsScenario) else "rigid"


def start_loop(
    scenario: AnyScenario, recipe: ControllerRecipe, seeds: Sequence[int], physics: str
) -> ControlLoop | WaypointsLoop:
    """The loop of either world."""
    if isinstance(scenario, WaypointsScenario):
        return WaypointsLoop(scenario, recipe, seeds, physics)
    return ControlLoop(scenario, recipe, seeds, physics)


def _controller(recipe: ControllerRecipe, world: World, seeds: Sequence[int]) -> Controller:
    """The running controller; a reference, and nobody else, is shown the truth."""
    if not is_reference(recipe):
        return recipe.build(world.scenario, seeds)
    truth = GroundTruth(read_only(world.state.pose), read_only(world.areas))
    return recipe.build_knowing(world.scenario, seeds, truth)
