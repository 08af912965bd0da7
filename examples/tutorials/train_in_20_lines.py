# %% [markdown]
# # Train in 20 lines with plain stable-baselines3
#
# The environment has a Gymnasium id, so stable-baselines3 makes it, trains on it and saves the
# model without any code of this project. One robot learns to drive among four hand-written ones. It
# takes some minutes and needs `pip install '.[train,render]'`.

# %%
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import torch
from PIL import Image
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.monitor import load_results

# %% tags=["parameters"]
STEPS = 250_000  # a step is one second of one robot
SECONDS = 300  # of a test episode
EPISODES = 20
FOLDER = "runs/tutorials/plain"

# %% [markdown]
# ## Train
#
# `near` is a small arena with five robots, and an episode lasts five minutes. The reward is 1 for
# each round trip of the learner.

# %%
torch.set_num_threads(1)  # faster for networks of this size
env = make_vec_env("swarm_forage_env:SwarmForage/Near-v2", n_envs=8, seed=1, monitor_dir=FOLDER)
model = PPO("MlpPolicy", env, n_steps=512, batch_size=256, seed=1, device="cpu")
model.learn(STEPS)
model.save(f"{FOLDER}/near.zip")

# %% [markdown]
# The monitor of stable-baselines3 has logged the reward of every episode.

# %%
rewards = load_results(FOLDER)["r"]
print(len(rewards), "episodes, mean reward of the last 50:", round(rewards.tail(50).mean(), 2))
figure, axes = plt.subplots(figsize=(6.0, 3.0), layout="constrained")
axes.plot(rewards, ".", markersize=2, color="0.7", label="an episode")
axes.plot(rewards.rolling(50).mean(), label="mean of 50 episodes")
axes.set(xlabel="episode of training", ylabel="round trips of the learner")
_ = axes.legend()

# %% [markdown]
# ## Evaluate
#
# A saved model is a controller by name, `sb3:FILE`. The model carries a card with the keywords that
# it was trained under, so none has to be repeated. In the evaluation it drives all five robots, on
# seeds that the training has not met.


# %%
def swarm_forage(*arguments):
    """Run the command line and print what it prints."""
    run = [sys.executable, "-m", "training.cli", *map(str, arguments)]
    print(subprocess.run(run, check=True, capture_output=True, text=True).stdout)


file = Path(FOLDER) / "near.zip"
test = ["--seed=1000", f"--episodes={EPISODES}", f"--set=task.duration={SECONDS}"]
swarm_forage("evaluate", "near", "nc", "ssgikf", f"sb3:{file}", *test, "--out", f"{FOLDER}/data")

# %% [markdown]
# ## Watch
#
# `--html near.html` writes a replay for any browser, `--video near.mp4` a clip and `--frame` a
# still picture.

# %%
frame = Path(FOLDER) / "near.png"
last = f"--start={SECONDS - 1}"
swarm_forage("watch", "near", f"sb3:{file}", "--seed=1000", last, "--size=480", "--frame", frame)
Image.open(frame)

# %% [markdown]
# Next: [all robots learn with one policy](learn_a_motion.md), many times as fast.
