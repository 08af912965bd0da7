# %% [markdown]
# # A policy onto a Cortex-M4
#
# `swarm-forage export` compiles the controller of one robot for the processor of the e-puck 2. The
# machine code consists of the functions that the simulator runs, so that nothing is written twice.
# This tutorial exports hand-written and learned controllers, checks the code bit for bit, and
# plots what the check replays. It takes a minute and needs `pip install '.[evaluate]'`
# and a C compiler named `cc`.

# %%
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from baselines.evaluation.experiment_config import find_layered_controller
from baselines.export.robot import ExportedRobot
from swarm_forage_env import find_scenario

# %% tags=["parameters"]
CONTROLLERS = ("nc", "ssgikf", "learned-motion", "learned-both")
CHECKED = "learned-both"
TICKS = 1200  # of the plot, 0.1 s each

# %%
OUT = Path("runs/tutorials/robot")


def swarm_forage(*arguments):
    """Run the command line: what it prints."""
    command = [sys.executable, "-m", "training.cli", *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


# %% [markdown]
# ## Export
#
# A policy of your own takes the place of the name, as `sb3:model.zip` or
# `network:best.safetensors`.

# %%
for name in CONTROLLERS:
    print(swarm_forage("export", name, "--target", "cortex-m4", "--out", OUT / name), end="")

# %% [markdown]
# The chip, an STM32F407, has 1 MB of flash memory and 192 kB of RAM.

# %%
sizes = {name: (OUT / name / "controller.o").stat().st_size / 1024 for name in CONTROLLERS}
figure, axes = plt.subplots(figsize=(6.0, 2.4), layout="constrained")
axes.barh(list(sizes), list(sizes.values()))
axes.invert_yaxis()
_ = axes.set(xlabel="size of controller.o [kB] (the chip has 1,024)")

# %% [markdown]
# ## Is it the same controller?
#
# The folder holds 1,000 recorded ticks of a simulated robot and a program in C that replays them.
# Exported for this machine, the program runs here. The tests of the project run it on an emulated
# Cortex-M4, too, with the same result.

# %%
folder = OUT / "here"
swarm_forage("export", CHECKED, "--target", "x86-64", "--out", folder)
compiler = ["cc", "-O2", "example.c", "controller.o", "-o", "example"]
subprocess.run(compiler, cwd=folder, check=True)
print(subprocess.run("./example", cwd=folder, check=True, capture_output=True, text=True).stdout)

# %% [markdown]
# ## What is replayed
#
# In each tick the code gets the readings and the received messages, and returns the speeds of the
# wheels and the message to broadcast.

# %%
robot = ExportedRobot(find_layered_controller(CHECKED), find_scenario("es1"))
ticks = robot.record_vectors(seed=3, i=0, n_ticks=TICKS)
print({name: ticks[name].shape for name in ticks.dtype.names})

# %%
seconds = np.arange(TICKS) * 0.1
figure, (above, below) = plt.subplots(
    2, figsize=(6.5, 3.8), sharex=True, layout="constrained", height_ratios=(2, 1)
)
above.plot(seconds, ticks["wheels"], linewidth=0.8, label=["left", "right"])
above.set(ylabel="wheels\n[of cruise speed]")
above.legend(loc="lower left")
below.plot(seconds, ticks["readings"]["proximity"].max(axis=1), color="C2", linewidth=0.8)
_ = below.set(xlabel="time [s]", ylabel="largest\nproximity")

# %% [markdown]
# ## On the robot
#
# ```c
# static controller_t controller;
#
# controller_init(&controller, my_number, seed);     /* numbers count from 0 */
# while (1) {                                        /* every 0.1 s */
#     controller_readings_t readings = sense();
#     controller_received_t received[CONTROLLER_SLOTS];
#     int n = receive(received);
#     controller_command_t command;
#     if (controller_tick(&controller, &readings, received, n, &command))
#         stop();                                    /* the header says when */
#     else
#         drive(command.wheels, command.is_speaking ? &command.payload : 0);
# }
# ```
#
# Units, frames, instructions per tick and what remains between simulation and robot:
# [from simulation to an e-puck](../guides/robot.md). Nobody has tried the code on a robot yet.
