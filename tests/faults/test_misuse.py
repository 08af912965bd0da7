"""Misuse of the environments, and policies that mean harm: one clear line, or a sound result."""

import math
import time

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.error import ResetNeeded

from baselines.cli import run
from baselines.evaluation.episode import run_episodes
from swarm_forage_env import ArrayEnv, ConfigError, UnknownNameError, parallel_env
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from training.vec_env import SwarmVecEnv

pytestmark = pytest.mark.faults

TOLD = ConfigError, UnknownNameError, ResetNeeded
FEW = {"task.n_robots": 3, "task.duration": 2.0, "physics": "kinematic"}
KEYWORDS = ("learn", "controller", "action", "observation", "reward", "normalise", "physics",
            "decision_period", "max_cycles", "shaping", "discount", "residual", "learners",
            "randomise", "render_mode", "threads", "task.n_robots", "radio.max_range",
            "lern")  # fmt: skip
JUNK = (
    None, 0, -1, 1, 2.5, 1e308, math.nan, math.inf, "", "x", "motion", "rigid", True, [], [0], [9],
    ["x"], {}, {"x": 1}, {"task.duration": (1, 2)}, (), (0, 1), b"x", object(), np.zeros(2), len,
    2**70, 10**400, [[0.0, 0.0], [0.0]], np.array(3), "es1\n",
    {"radio.max_range": (0.3, 0.1)},
)  # fmt: skip
OPTIONS = (None, {}, 5, [], "x", {"x": 1}, {"task.area_distance": "far"}, {"task.n_robots": 5},
           {"scenario": 3})  # fmt: skip
SEEDS = (None, 0, -1, 1.5, "x", 2**64, 2**70, 10**400, True, [1, 2], np.array(3))


def made(kind, options):
    """An environment of the API of this name."""
    if kind == "pettingzoo":
        return parallel_env("es1", **options)
    if kind == "array":
        return ArrayEnv("es1", 2, **options)
    if kind == "sb3":
        return SwarmVecEnv("es1", n_worlds=2, **options)
    return gymnasium.make("SwarmForage/ES1-Joint-v2", disable_env_checker=True, **options).unwrapped


def step_with(env, kind, junk, rng):
    """Take a step with junk in the place of the actions, or of one number of them."""
    if kind == "pettingzoo":
        actions = {agent: np.zeros(2, np.float32) for agent in env.agents}
        actions[rng.choice(sorted(actions) or ["x"])] = junk
        return env.step(rng.choice([actions, junk]))
    return env.step(junk)


def misuse(kind, rng):
    """One misuse of an API: a description, and what does it."""
    options, junk = dict(FEW), rng.choice(JUNK)
    call = rng.choice(["make", "reset", "step", "step first"])
    if call == "make":
        own = [each for each in KEYWORDS if (kind, each) != ("gymnasium", "render_mode")]
        options[rng.choice(own)] = junk  # gymnasium.make reads the mode itself
    reset = {"seed": 1}
    if call == "reset":
        reset = {"seed": rng.choice(SEEDS), "options": rng.choice(OPTIONS)}

    def do():
        env = made(kind, options)
        if call != "step first":
            env.reset(**({} if kind == "sb3" else reset))
        if call.startswith("step"):
            step_with(env, kind, junk, rng)

    return f"{kind}, {call}, {options}, {junk!r}, {reset}", do


@pytest.mark.parametrize("kind", ["pettingzoo", "array", "gymnasium", "sb3"])
@pytest.mark.filterwarnings("ignore")  # gymnasium warns of what is then refused
def test_misuse_gets_one_clear_line(kind, tries, rng, tell):
    refused, foreign = 0, []
    for _ in range(tries(300)):
        what, do = misuse(kind, rng)
        try:
            do()
        except TOLD as error:
            refused += 1
            if "\n" in str(error).strip():
                foreign.append((what, "more than a line"))
        except Exception as error:
            foreign.append((what, repr(error)[:100]))
    assert not foreign, f"{len(foreign)} of {tries(300)}: {foreign[:3]}"
    tell(tried=tries(300), refused=refused, failed=0)


HOSTILE = {
    "nan": lambda seen: np.full((len(seen), 2), np.nan),
    "infinite": lambda seen: np.full((len(seen), 2), np.inf),
    "huge": lambda seen: np.full((len(seen), 2), 3.4e38, np.float32),
    "one nan": lambda seen: np.where(np.arange(2 * len(seen)).reshape(-1, 2) == 3, np.nan, 0.0),
    "too few": lambda seen: np.zeros((len(seen) - 1, 2)),
    "too wide": lambda seen: np.zeros((len(seen), 3)),
    "flat": lambda seen: np.zeros(2 * len(seen)),
    "text": lambda seen: [["fast", "slow"]] * len(seen),
    "nothing": lambda seen: None,
    "a number": lambda seen: 0.5,
    "complex": lambda seen: np.zeros((len(seen), 2), complex),
    "ragged": lambda seen: [[0.0] * (1 + k) for k in range(len(seen))],
    "with gradients": lambda seen: torch.zeros(len(seen), 2, requires_grad=True),
    "objects": lambda seen: np.full((len(seen), 2), object()),
    "overwriting": lambda seen: seen.fill(np.nan) or np.zeros((len(seen), 2)),
}
"""What a policy gives back."""


def hostile(name):
    """A policy that turns hostile after some calls."""
    calls = []

    def policy(seen):
        calls.append(1)
        return np.zeros((len(seen), 2), np.float32) if len(calls) < 3 else HOSTILE[name](seen)

    return policy


def raising(seen):
    raise ZeroDivisionError("of the user's own")


def slow(seen):
    time.sleep(0.002)
    return np.zeros((len(seen), 2), np.float32)


@pytest.fixture
def policies(monkeypatch, tmp_path):
    """A module of the policies above, which controllers go by: callable:hostile_policies:nan."""
    import sys
    from types import ModuleType

    module = ModuleType("hostile_policies")
    for name in HOSTILE:
        setattr(module, name.replace(" ", "_"), hostile(name))
    module.raising, module.slow = raising, slow
    monkeypatch.setitem(sys.modules, "hostile_policies", module)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("physics", ["kinematic", "rigid"])
@pytest.mark.parametrize("threads", [1, 3])
def test_a_hostile_policy_is_named_or_changes_nothing(policies, physics, threads, tell):
    scenario, refused = find_scenario("es1", {"task.n_robots": 3, "task.duration": 3.0}), 0
    messages = []
    for name in HOSTILE:
        controller = find_controller(f"callable:hostile_policies:{name.replace(' ', '_')}")
        try:
            found = run_episodes(scenario, controller, (0, 1, 2), physics, threads)
        except ConfigError as error:
            refused += 1
            messages.append(str(error))
        else:
            assert all(math.isfinite(each.localisation_error_m or 0.0) for each in found)
    unclear = [each for each in messages if "hostile_policies" not in each or "\n" in each]
    assert not unclear
    tell(tried=len(HOSTILE), refused=refused, failed=0)


def test_a_command_with_a_hostile_policy_keeps_nothing(policies, capsys, tmp_path, tell):
    short = "--set=task.duration=3", "--workers=1", "--episodes=2", "--out=out"
    for name in HOSTILE:
        label = f"callable:hostile_policies:{name.replace(' ', '_')}"
        status = run(["evaluate", "es1", label, *short])
        lines = capsys.readouterr().err.splitlines()
        kept = [*(tmp_path / "out").rglob("*.parquet")]
        if status:
            assert not kept
            assert lines[-1].startswith("swarm-forage: ")
        for file in kept:
            file.unlink()
    assert run(["evaluate", "es1", "callable:hostile_policies:slow", *short]) == 0
    with pytest.raises(ZeroDivisionError, match="of the user's own"):
        run(["evaluate", "es1", "callable:hostile_policies:raising", *short])
    tell(tried=len(HOSTILE) + 2, failed=0)
