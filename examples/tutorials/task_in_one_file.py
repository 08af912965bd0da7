# %% [markdown]
# # A task of your own in one file
#
# The task: e-puck robots *aggregate*. Each earns the share of the swarm that is within 0.3 m of it.
# Body, sensors, radio, contacts and the tick are those of the built-in e-puck, and the file below
# adds what is new. Every API and command then runs the task. It takes a minute and needs
# `pip install '.[train,render]'`.

# %%
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from stable_baselines3 import PPO

# %% tags=["parameters"]
ROBOT_STEPS = 4_000_000
N_WORLDS = 8
TEST_SEEDS = range(1000, 1020)

# %%
OUT = Path("runs/tutorials")
OUT.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The file
#
# 1. The *scenario* holds the numbers: `range` is new, the rest is that of the e-puck.
# 2. The *records* hold what the world and each robot remember, with units.
# 3. `score` writes the reward of robot i in every tick. Compiled functions (`@kernel`) run for all
#    robots of all worlds.
# 4. The *episode* says what a run is judged by.

# %%
TASK = '''"""Aggregation without spots: robots come together anywhere."""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from swarm_forage_env.compiler import kernel
from swarm_forage_env.episode import Episode, EpisodeKind, judged_at_the_end
from swarm_forage_env.epuck.parts import Arena, Mission, Radio
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.epuck.task import EpuckTask
from swarm_forage_env.epuck.world import EpuckWorld
from swarm_forage_env.parameters import Positive
from swarm_forage_env.record import field
from swarm_forage_env.registry import SCENARIOS


class ComeTogether(Mission):
    """The numbers of the task."""

    range: Positive = Field(0.3, description="Distance that counts as together [m]")


class ComeTogetherScenario(EpuckScenario):
    """Every number of a world."""

    task: ComeTogether = ComeTogether()


class ComeTogetherWorldState(EpuckWorldState):
    """A world; `range` stands in its record for the compiled functions."""

    range: float = field(np.float64, unit="m")


class ComeTogetherState(EpuckState):
    """An e-puck."""

    together: float = field(np.float64)
    """Share of the swarm within range, itself included. Writer: score."""


@kernel
def brightness_at(x, y, world):
    """A white floor."""
    return 1.0


@kernel
def score(swarm, i, world):
    """Reward robot i by the share of the swarm within range, for each second."""
    robot, count = swarm[i], 0
    for j in range(swarm.shape[0]):
        dx, dy = robot.pose[0] - swarm[j].pose[0], robot.pose[1] - swarm[j].pose[1]
        count += dx * dx + dy * dy < world.range * world.range
    robot.together = count / swarm.shape[0]
    robot.reward = world.dt * robot.together


class ComeTogetherWorld(
    EpuckWorld,
    robot=ComeTogetherState,
    world=ComeTogetherWorldState,
    functions={"brightness_at": brightness_at, "score": score},
):
    """Worlds of the task, side by side."""

    @staticmethod
    def write_task(scenario, out_worlds):
        """Write the numbers of the task into the records."""
        out_worlds["range"] = scenario.task.range


@dataclass(frozen=True, kw_only=True)
class ComeTogetherEpisode(Episode):
    """The result of one episode: the mean of `together` at its end."""

    together: float


def together(world):
    """The mean share of each swarm."""
    return world.robots["together"].mean(axis=1)


EpuckTask(
    name="come-together",
    scenario=ComeTogetherScenario,
    world=ComeTogetherWorld,
    controller="gather",
    episode=EpisodeKind(
        ComeTogetherEpisode,
        judged_at_the_end(lambda world: {"together": together(world)}),
        "together",
        "Share together",
        {"together": ("together\\n[%]", 100.0)},
    ),
    headings=("Share of the robot", "Share of the swarm"),
    shown=lambda world, w: (world.robots["together"][w], together(world)[w]),
).register()

SCENARIOS.register("come-together", "robots come together anywhere")(
    ComeTogetherScenario(
        name="come-together",
        arena=Arena(length=2.0, width=2.0),
        radio=Radio(max_range=0.5),
        task=ComeTogether(n_robots=10, duration=120.0, start_radius=0.9),
    )
)
'''
_ = (OUT / "come_together.py").write_text(TASK, encoding="utf-8")

# %% [markdown]
# ## Run it
#
# Importing the file registers the task. A package does so by an entry point
# ([write your own rule as a package](a_rule_as_a_package.md)).

# %%
sys.path.insert(0, str(OUT))
import come_together  # registers the task

from baselines.evaluation.episode import run_episodes
from swarm_forage_env import find_scenario, parallel_env
from swarm_forage_env.controllers import find_controller

env = parallel_env("come-together", learn="motion", render_mode="rgb_array")
observations, infos = env.reset(seed=1000)
print(len(env.agents), "robots,", observations["epuck_0"].shape[0], "numbers observed")

# %% [markdown]
# ## Learn it
#
# PPO learns the motion from the reward above. Robots of such a task have no estimator and their
# radio is always on, so that a policy observes the sensors and the received messages.

# %%
import torch

from training.vec_env import SwarmVecEnv

torch.set_num_threads(1)
rows = SwarmVecEnv("come-together", n_worlds=N_WORLDS)
model = PPO("MlpPolicy", rows, n_steps=120, gamma=0.98, batch_size=480, seed=1, device="cpu")
model.learn(ROBOT_STEPS // 10)
model.save(OUT / "come_together.zip")

# %%
scenario = find_scenario("come-together")
shares = {}
for name in ("gather", f"sb3:{OUT / 'come_together.zip'}"):
    episodes = run_episodes(scenario, find_controller(name), TEST_SEEDS)
    shares[name] = [episode.together for episode in episodes]
    print(f"{name:50} {np.mean(shares[name]):.2f} together")

# %%
figure, axes = plt.subplots(figsize=(6.0, 2.2), layout="constrained")
labels = ["gather,\nhand-written", "learned"]
axes.boxplot(list(shares.values()), orientation="horizontal", tick_labels=labels)
_ = axes.set(xlabel="share of the swarm within 0.3 m of a robot, at the end", xlim=(0, 1))

# %% [markdown]
# ## Watch it
#
# The learned policy drives the environment of above to its end.

# %%
while env.agents:
    observed = np.stack([observations[agent] for agent in env.agents])
    actions, _ = model.predict(observed, deterministic=True)
    chosen = dict(zip(env.agents, actions, strict=True))
    observations, rewards, terminations, truncations, infos = env.step(chosen)
figure, axes = plt.subplots(figsize=(5.0, 5.0), layout="constrained")
axes.imshow(env.render())
_ = axes.set_axis_off()

# %% [markdown]
# Next: [`aggregation`](../../swarm_forage_env/aggregation.py), the built-in task with two black
# spots, is written in the same way, and [a task of your own](../guides/task.md) explains each
# part. `swarm-forage new task NAME` writes such a package with its test.
