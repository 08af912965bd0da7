"""A single learner among robots that keep the hand-written layers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Controller, ControllerRecipe


@dataclass(frozen=True)
class AmongTeamMates:
    """A recipe that a policy replaces for the first robot of each world only."""

    recipe: ControllerRecipe

    @property
    def message_path(self) -> float:
        """What a message adds to a path [m]."""
        return float(getattr(self.recipe, "message_path", 0.0))

    def build(self, scenario: Any, seeds: Sequence[int]) -> "TeamController":  # noqa: ANN401 either world
        """The running controller for a block of worlds, one for each seed."""
        return TeamController(self.recipe.build(scenario, seeds), scenario.task.n_robots)

    def with_parameters(self, values: dict[str, Any]) -> "AmongTeamMates":
        """The same with some parameters of the recipe changed."""
        return AmongTeamMates(self.recipe.with_parameters(values))


class TeamController:
    """A controller whose own layers go on for all robots but the first of each world.

    The layer that is learned runs on all rows, as it does without a learner, so that what it
    remembers and draws stays the same; then the rows of the learners are replaced.
    """

    def __init__(self, controller: Controller, n_robots: int) -> None:
        """Of worlds with so many robots each."""
        self._controller = controller
        self._learners = slice(None, None, n_robots)
        self.estimator = controller.estimator
        self.weighting = controller.weighting
        self.motion = controller.motion
        self.observe = controller.observe
        self.reset = controller.reset

    def command(
        self,
        g: Float32[Array, "rows weights"] | None = None,
        wheels: Float32[Array, "rows 2"] | None = None,
    ) -> Any:  # noqa: ANN401 the command of its world
        """The next command; of a weight or wheels from outside only the learners' rows count."""
        estimator = self.estimator
        if wheels is not None:
            wheels = self._replaced(self.motion(estimator.situation), wheels)
        if g is not None and estimator.encounter.valid.any():
            g = self._replaced(self.weighting(estimator.encounter), g)
        return self._controller.command(g, wheels)

    def _replaced(
        self, own: Float32[Array, "rows numbers"], policy: Float32[Array, "rows numbers"]
    ) -> Float32[Array, "rows numbers"]:
        """What the layer itself does, but for the learners."""
        mixed = own.copy()
        mixed[self._learners] = policy[self._learners]
        return mixed
