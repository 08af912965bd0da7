"""The environment of the waypoints world on arrays: cuts, observations, truth and batch.

The same as `batch`, `cuts`, `observation` and `truth` for foraging.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.layout import Field, Layout, ObservationLayout, Sheet, Slot, field
from swarm_forage_env.envs.rewards import REWARDS, Shaping
from swarm_forage_env.envs.stepping import Stepping
from swarm_forage_env.envs.terms import Terms, cycles_of
from swarm_forage_env.interface import WORDS, ControllerRecipe
from swarm_forage_env.loop import WaypointsLoop
from swarm_forage_env.registry import Registry
from swarm_forage_env.waypoints_interface import (
    Correction,
    WaypointCommand,
    WaypointFeedback,
    WaypointSituation,
)
from swarm_forage_env.waypoints_scenario import WaypointsScenario
from swarm_forage_env.waypoints_world import WaypointsState, WaypointsWorld

FAR = 1e9
"""Bound of what a filter may believe: none can be proven, and none seen comes near."""

UNIT, FLAG, PULL = (0.0, 1.0), (0.0, 1.0), (-1.0, 1.0)
ANGLE = (-math.pi, math.pi)
ANYWHERE, ANY_SIZE = (-FAR, FAR), (0.0, FAR)

G = Slot("g", "weight", *UNIT)
"""The share of the correction by all neighbours that is carried out."""

PULLS = tuple(Slot(f"pull.{side}", "of the highest acceleration", *PULL) for side in ("x", "y"))

CLAIM = Slot("claim", "at the goal if > 0", *PULL)

SAID = tuple(Slot(f"words.{word}", "as sent", *PULL) for word in range(WORDS))

INFOS = ("goals", "false_goals", "position_error_m")
"""What is logged of each robot: claims right and wrong so far, and how far its belief is off."""


def correction_fields() -> tuple[Field, ...]:
    """The correction that is about to be made, as `Correction` says."""
    return (
        field("valid", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        field("neighbours", ("",), "of all robots", UNIT, shape=()),
        field("own_doubt", ("",), "m^2", ANY_SIZE, shape=()),
        field("heard_doubt", ("",), "m^2", ANY_SIZE, shape=()),
        field("disagreement", ("",), "m", ANY_SIZE, shape=()),
    )


def flock_fields() -> tuple[Field, ...]:
    """What the motion layer sees, as `WaypointSituation` says."""
    ways = (("goal", "m"), ("home", "m"), ("centre", "m"), ("crowd", ""), ("flow", ""))
    vectors = [field(name, "xy", unit, ANYWHERE) for name, unit in (*ways, ("velocity", "m/s"))]
    shares = [field(name, ("",), "share", ANY_SIZE, shape=()) for name in ("doubt", "drift")]
    return (
        *vectors,
        field("density", ("",), "of all robots", UNIT, shape=()),
        *shares,
        field("arrived", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        field("pull", "xy", "of the highest acceleration", PULL),
    )


def reading_fields(scenario: WaypointsScenario) -> tuple[Field, ...]:
    """What the robot's own sensors say, as `WaypointReadings` says."""
    sensors = scenario.sensors
    motion = (
        Slot("motion.speed", "m/s", *ANYWHERE, f"sd {sensors.speed_noise:g} m/s and a bias"),
        Slot("motion.turn", "rad/s", *ANYWHERE, f"sd {sensors.turn_noise:g} rad/s and a bias"),
    )
    fix = f"sd {sensors.home_noise:g}"
    return (
        Field("motion", (2,), np.float32, motion),
        field("compass", ("",), "rad", ANGLE, shape=()),
        field("at_home", ("",), "0 or 1", FLAG, shape=(), dtype=np.bool_),
        field("fix", ("x", "y", "heading"), "m, rad", ANYWHERE, fix),
        field("goal", "xy", "m", ANYWHERE),
    )


def sighting_fields(scenario: WaypointsScenario) -> tuple[Field, ...]:
    """Who is seen, as `Sightings` says, and what they said."""
    sensors, others = scenario.sensors, [str(k) for k in range(scenario.task.n_robots)]
    told = [f"{other}.{word}" for other in others for word in range(WORDS)]
    return (
        field("seen", others, "0 or 1", FLAG, dtype=np.bool_),
        field("range", others, "m", (0.0, sensors.reach), f"sd {sensors.range_noise:g} m"),
        field("bearing", others, "rad", ANGLE, f"sd {sensors.bearing_noise:g} rad"),
        field("words", told, "as sent", PULL, shape=(len(others), WORDS)),
    )


WAYPOINT_CUTS: Registry[Any] = Registry("layer to learn")
"""Cuts by the name that `learn` takes."""


class _LayerCut:
    """A control loop of which some layers are the policy's."""

    def __init__(
        self, scenario: WaypointsScenario, recipe: ControllerRecipe, seeds: Sequence[int],
        physics: str,
    ) -> None:  # fmt: skip
        """One world for each seed."""
        self._loop = WaypointsLoop(scenario, recipe, seeds, physics)
        self.world = self._loop.world

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        self._loop.reset(seeds)

    @property
    def parts(self) -> Mapping[str, Any]:
        """What either layer is shown."""
        estimator = self._loop.controller.estimator
        return {"encounter": estimator.encounter, "situation": estimator.situation}

    @property
    def beliefs(self) -> Float64[Array, "rows 3"] | None:
        """Where the robots believe to be."""
        estimator: Any = self._loop.controller.estimator
        pose: Float64[Array, "rows 3"] = estimator.pose
        return pose


@WAYPOINT_CUTS.register("weighting")
class WeightingCut(_LayerCut):
    """The policy sees each correction and says how much of it is done."""

    action_layout: ClassVar[Layout] = Layout((G,))

    def fields(self) -> dict[str, tuple[Field, ...]]:
        """The correction."""
        return {"encounter": correction_fields()}

    def tick(self, action: Float32[Array, "rows 1"]) -> WaypointFeedback:
        """One tick with the policy's weights."""
        feedback: WaypointFeedback = self._loop.step(g=action)
        return feedback


@WAYPOINT_CUTS.register("motion")
class MotionCut(_LayerCut):
    """The policy sees the situation and steers."""

    action_layout: ClassVar[Layout] = Layout(PULLS)

    def fields(self) -> dict[str, tuple[Field, ...]]:
        """The situation."""
        return {"situation": flock_fields()}

    def tick(self, action: Float32[Array, "rows 2"]) -> WaypointFeedback:
        """One tick with the policy's pull."""
        feedback: WaypointFeedback = self._loop.step(wheels=action)
        return feedback


@WAYPOINT_CUTS.register("both")
class BothCut(_LayerCut):
    """The policy weighs and steers."""

    action_layout: ClassVar[Layout] = Layout((G, *PULLS))

    def fields(self) -> dict[str, tuple[Field, ...]]:
        """The correction, then the situation."""
        return {"encounter": correction_fields(), "situation": flock_fields()}

    def tick(self, action: Float32[Array, "rows 3"]) -> WaypointFeedback:
        """One tick with the policy's weights and pull."""
        g, pull = np.ascontiguousarray(action[:, :1]), np.ascontiguousarray(action[:, 1:])
        feedback: WaypointFeedback = self._loop.step(g, pull)
        return feedback


@WAYPOINT_CUTS.register("everything")
class EverythingCut:
    """The policy sees raw readings and sightings, steers, claims and speaks; nothing else runs.

    What is said in a tick is heard after it by those who see the speaker.
    """

    action_layout: ClassVar[Layout] = Layout((*PULLS, CLAIM, *SAID))
    beliefs = None

    def __init__(
        self, scenario: WaypointsScenario, recipe: ControllerRecipe, seeds: Sequence[int],
        physics: str,
    ) -> None:  # fmt: skip
        """One world for each seed; the recipe is not used."""
        self.world = WaypointsWorld(scenario, seeds, physics)
        self._said = np.zeros((self.world.n_worlds, self.world.n_robots, WORDS), np.float32)

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        self.world.reset(seeds)
        self._said[:] = 0.0

    def fields(self) -> dict[str, tuple[Field, ...]]:
        """The readings, then the sightings."""
        scenario = self.world.scenario
        return {"readings": reading_fields(scenario), "heard": sighting_fields(scenario)}

    @property
    def parts(self) -> Mapping[str, Any]:
        """What the last tick gave back."""
        feedback = self.world.feedback
        return {"readings": feedback.readings, "heard": _Heard(feedback, self._said)}

    def tick(self, action: Float32[Array, "rows numbers"]) -> WaypointFeedback:
        """One tick with the policy's pull, claim and words."""
        self._said[:] = action[:, 3:].reshape(self._said.shape)
        pull, claim = np.ascontiguousarray(action[:, :2]), action[:, 2] > 0.0
        return self.world.tick(WaypointCommand(pull, claim))


class _Heard:
    """Sightings together with the words of those seen."""

    def __init__(
        self, feedback: WaypointFeedback, said: Float32[Array, "worlds robots words"]
    ) -> None:
        """Zeros for whoever is not seen."""
        self.seen, self.range = feedback.heard.seen, feedback.heard.range
        self.bearing = feedback.heard.bearing
        spoken = np.repeat(said, said.shape[1], axis=0)
        self.words = np.where(self.seen[:, :, None], spoken, np.float32(0.0))


class WaypointObservationLayout(ObservationLayout):
    """The layout of an observation of this world."""

    def encounter(self, observations: Float32[Array, "rows numbers"]) -> Any:  # noqa: ANN401
        """The `Correction` that the weighting layer sees."""
        return self._part("encounter", Correction, observations)

    def situation(self, observations: Float32[Array, "rows numbers"]) -> Any:  # noqa: ANN401
        """The `WaypointSituation` that the motion layer sees."""
        return self._part("situation", WaypointSituation, observations)


class WaypointTruth:
    """What is true in a block of worlds, flat: each robot, then the time.

    Of each robot: pose, goal, and where it believes to be; zeros for the belief where no
    hand-written estimator runs.
    """

    def __init__(self, world: WaypointsWorld, agents: list[str]) -> None:
        """The truth about these worlds, whose robots have these names."""
        self._world = world
        names = ("pose.x", "pose.y", "heading.cos", "heading.sin", "goal.x", "goal.y")
        believed = ("believed.x", "believed.y")
        slots = [
            Slot(f"{agent}.{name}", "" if name.startswith("heading") else "m", *ANYWHERE)
            for agent in agents
            for name in (*names, *believed)
        ]
        self.layout = Layout([*slots, Slot("share_gone", "of the episode", *UNIT)])
        self.space = self.layout.box()

    def state(
        self, beliefs: Float64[Array, "rows 3"] | None, share_gone: float
    ) -> Float32[Array, "worlds numbers"]:
        """One row for each world, as the layout says."""
        state, worlds = self._world.state, self._world.n_worlds
        x, y, theta = state.pose.T
        believed = np.zeros_like(state.goal) if beliefs is None else beliefs[:, :2]
        parts = [np.stack([x, y, np.cos(theta), np.sin(theta)], axis=1), state.goal, believed]
        robots = np.concatenate(parts, axis=1).reshape(worlds, -1)
        gone = np.full((worlds, 1), min(share_gone, 1.0))
        return np.concatenate([robots, gone], axis=1, dtype=np.float32)

    def log(self, beliefs: Float64[Array, "rows 3"] | None) -> Float64[Array, "rows infos"]:
        """The numbers that are logged, a row for each robot, in the order of INFOS."""
        state = self._world.state
        off = np.zeros(self._world.rows)
        if beliefs is not None:
            off = np.hypot(*(beliefs[:, :2] - state.pose[:, :2]).T)
        return np.stack([state.right, state.wrong, off], axis=1)


class WaypointPotential(Shaping):
    """How far each robot has come: goals reached, and the way to the next.

        Phi = goals + 1 - d / far

    d is the true distance to the goal [m], `far` the diagonal of the square of goals.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """

    def __init__(self, scenario: WaypointsScenario, discount: float, weight: float) -> None:
        """The potential of a scenario."""
        super().__init__(discount, weight)
        self._far = math.hypot(scenario.task.side, scenario.task.side)

    def __call__(self, state: WaypointsState) -> Float64[Array, " rows"]:
        """Phi of every robot."""
        d = np.hypot(*(state.goal - state.pose[:, :2]).T)
        return np.asarray(state.right + 1.0 - d / self._far)


class WaypointBatch(Stepping):
    """Worlds, controllers, spaces and rewards; a row of every array is a robot.

    A goal rightly claimed earns 1, in the tick after the robot said so; what it would say on the
    last observation comes too late, though `swarm-forage evaluate` counts that as well.
    """

    infos = INFOS

    def __init__(
        self,
        scenario: WaypointsScenario,
        terms: Terms,
        controller: str | ControllerRecipe,
        seeds: Sequence[int],
    ) -> None:
        """One world for each seed, ready to step."""
        self.n_cycles = cycles_of(scenario, terms)
        recipe = find_controller(controller)
        self._reward = REWARDS[terms.reward]
        self._period = terms.decision_period
        physics = terms.physics or "kinematic"
        self.cut: Any = WAYPOINT_CUTS[terms.learn](scenario, recipe, seeds, physics)
        self.world: WaypointsWorld = self.cut.world
        self.agents = [f"create_{k}" for k in range(self.world.n_robots)]
        self.observation_layout = WaypointObservationLayout(self.cut.fields())
        self.action_layout: Layout = self.cut.action_layout
        self.truth = WaypointTruth(self.world, self.agents)
        self._sheet = Sheet(self.observation_layout, self.world.rows)
        self._potential = WaypointPotential(scenario, terms.discount, terms.shaping)
        self._shaped = terms.shaping > 0.0
