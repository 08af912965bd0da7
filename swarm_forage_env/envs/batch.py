"""The environment on arrays: W worlds side by side. Every API in this folder wraps it."""

from collections.abc import Sequence

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.bounds import Bounds
from swarm_forage_env.envs.cuts import CUTS, RESIDUAL_CUTS, Cut
from swarm_forage_env.envs.layout import ObservationLayout, Sheet
from swarm_forage_env.envs.rewards import REWARDS, Potential
from swarm_forage_env.envs.stepping import Stepping
from swarm_forage_env.envs.terms import Terms, cycles_of
from swarm_forage_env.envs.truth import INFOS, Truth
from swarm_forage_env.interface import ControllerRecipe
from swarm_forage_env.scenario import Scenario


class Batch(Stepping):
    """Worlds, controllers, spaces and rewards; a row of every array is a robot.

    With a decision period of k ticks an action is held for k ticks, and the rewards of all k
    are added up. A weight g held so applies to every exchange that ends in these ticks, while
    the observation shows the last tick only: for `learn="weighting"` k = 1 is what the
    hand-written rules have.
    """

    infos = INFOS

    def __init__(
        self,
        scenario: Scenario,
        terms: Terms,
        controller: str | ControllerRecipe,
        seeds: Sequence[int],
    ) -> None:
        """One world for each seed, ready to step."""
        self.n_cycles = cycles_of(scenario, terms)
        recipe = find_controller(controller)
        self._reward = REWARDS[terms.reward]
        self._period = terms.decision_period
        cuts = RESIDUAL_CUTS if terms.residual else CUTS
        self.cut: Cut = cuts[terms.learn](scenario, recipe, seeds, terms.physics or "rigid")
        self.world = self.cut.world
        self.agents = [f"epuck_{k}" for k in range(self.world.n_robots)]
        n_ticks = max(scenario.n_ticks, self.n_cycles * self._period)
        bounds = Bounds(scenario, n_ticks, getattr(recipe, "message_path", 0.0))
        self.observation_layout = ObservationLayout(self.cut.fields(bounds))
        self.action_layout = self.cut.action_layout
        self.truth = Truth(self.world, self.agents, bounds)
        self._sheet = Sheet(self.observation_layout, self.world.rows)
        self._potential = Potential(scenario, terms.discount, terms.shaping)
        self._shaped = terms.shaping > 0.0
