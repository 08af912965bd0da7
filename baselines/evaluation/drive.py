"""Drive one robot by hand, in a window, among robots that a controller moves."""

from baselines.evaluation.console import say
from baselines.evaluation.experiment_config import ExperimentConfig
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.manual_policy import action_of
from swarm_forage_env.rendering.window import Window
from swarm_forage_env.scene import Scene


def drive(
    configuration: ExperimentConfig, seed: int, robot: int, window: Window, seconds: float
) -> None:
    """Run an episode in which the arrow keys move this robot, and say what it came to.

    It ends after so many seconds of its own time, or when the user closes the window.
    """
    env = ArrayEnv(
        configuration.scenario,
        controller=configuration.controller,
        learn="motion",
        learners=[robot],
        physics=configuration.physics,
        decision_period=1,
    )
    env.reset(seed)
    window.drive(robot)
    scene = env.loop.scene()
    window.show(scene)
    while not window.closed and scene.time < seconds - 1e-9:
        env.step(action_of(window.arrows, env.action_layout.names)[None, None])
        scene = env.loop.scene()
        window.show(scene)
    window.close()
    say(f"robot {robot}: {_score(scene, robot)} of the swarm's {scene.total}, in {scene.time:g} s")


def _score(scene: Scene, robot: int) -> str:
    if scene.localised is not None:
        return f"{scene.localised.right[robot]} goals reached"
    return f"{scene.round_trips[robot]} round trips"
