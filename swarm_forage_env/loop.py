"""The control loop: tick, listen, then weigh and steer, merge, and tick again.

    world.tick(command) -> controller.observe(feedback) -> controller.command(g, wheels) -> ...

Between `observe` and `command` lies the cut where a policy takes the place of a layer.
"""

from collections.abc import Sequence

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.ground_truth import GroundTruth, is_reference, read_only
from swarm_forage_env.interface import Controller, ControllerRecipe, Feedback
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.world import World


class ControlLoop:
    """A block of worlds and the controller of all their robots, in turn."""

    def __init__(
        self,
        scenario: Scenario,
        recipe: ControllerRecipe,
        seeds: Sequence[int],
        physics: str = "rigid",
    ) -> None:
        """One world for each seed, sensed and about to move."""
        self.world = World(scenario, seeds, physics)
        self.controller = _controller(recipe, self.world, seeds)
        self.controller.observe(self.world.feedback)

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        feedback = self.world.reset(seeds)
        for world, seed in enumerate(seeds):
            self.controller.reset(world, seed)
        self.controller.observe(feedback)

    def step(
        self,
        g: Float32[Array, "rows areas"] | None = None,
        wheels: Float32[Array, "rows 2"] | None = None,
    ) -> Feedback:
        """One tick; a weight g in [0, 1] or wheels in [-1, 1] replace that layer's own.

        Afterwards `controller.estimator.encounter` and `.situation` hold what either layer
        is shown next.
        """
        feedback = self.world.tick(self.controller.command(g, wheels))
        self.controller.observe(feedback)
        return feedback


def _controller(recipe: ControllerRecipe, world: World, seeds: Sequence[int]) -> Controller:
    """The running controller; a reference, and nobody else, is shown the truth."""
    if not is_reference(recipe):
        return recipe.build(world.scenario, seeds)
    truth = GroundTruth(read_only(world.state.pose), read_only(world.areas))
    return recipe.build_knowing(world.scenario, seeds, truth)
