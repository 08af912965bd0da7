"""Commands that write something, each of seconds, and how what they kept is read."""

import json
import subprocess

import pyarrow.parquet as pq
from safetensors.numpy import load_file

from tests import processes
from training.ladder.runs import read_runs

SHORT = "--workers=1", "--physics=kinematic"
BUSY = "--set=robot.cruise_speed=0.12", "--set=task.area_distance=0.62"


def train(algorithm, *more):
    """The command that trains a weighting by an algorithm."""
    return ("train", "weighting", "es1", f"--algorithm={algorithm}", "--held-back=2", *SHORT, *more)


EVALUATE = (
    "evaluate", "es1", "nc", "ssgikf", "--episodes=20", "--set=task.duration=200", "--workers=2",
)  # fmt: skip
CMA = train("cma", "--budget=6", "--every=2", "--worlds=2", "--population=4", "--set=duration=20")
IMITATION = train("imitation", "--budget=4", "--every=1", "--worlds=2", "--set=duration=120", *BUSY)
PPO = train("ppo", "--budget=15000", "--every=5000", "--worlds=1", "--set=task.duration=20")
BENCHMARK = (
    "benchmark", "ladder", "--rung=near", "--algorithm=sb3_ppo", "--seeds=2", "--budget=500",
    "--workers=1",
)  # fmt: skip
REPRODUCE = (
    "reproduce", "adaptive-boids", "--episodes=1", "--set=task.duration=10", "--workers=2",
)  # fmt: skip


def start(out, command):
    """Start a command in the folder of its output, in a process group of its own."""
    name = f"{out.name}.parquet" if command[0] == "benchmark" else out.name
    return processes.start(
        "-m", "training.cli", *command, f"--out={name}",
        cwd=out.parent, start_new_session=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip


def episodes(out):
    """The episodes of a dataset, without how long they took."""
    rows = pq.read_table(out).drop_columns("wall_s").to_pylist()
    return sorted(rows, key=lambda row: (row["scenario"], row["configuration"], row["seed"]))


def policy(out):
    """The best policy, its curve and its score; a card of PPO has these in a part of its own."""
    arrays = {name: array.tobytes() for name, array in load_file(out / "best.safetensors").items()}
    card = json.loads((out / "best.json").read_text())
    record = card.get("training", card)
    return arrays, record["curve"], record["score"]


def runs(out):
    """The runs of a benchmark, without how long they took."""
    found = {}
    for run in read_runs(out.with_suffix(".parquet")):
        timeless = [{k: v for k, v in point.items() if k != "wall_s"} for point in run.curve]
        found[run.identity] = (run.scores, timeless)
    return found


def claims(out):
    """The claims of a paper, its page and its episodes."""
    page = (out / "adaptive_boids.md").read_text()
    return json.loads((out / "claims.json").read_text()), page, episodes(out / "episodes")
