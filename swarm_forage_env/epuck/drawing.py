"""Drawing of a world of e-pucks: the parts common to all tasks."""

from typing import Any

import numpy as np

from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.epuck.world import EpuckWorld
from swarm_forage_env.scene import Outline


def walls(scenario: EpuckScenario) -> dict[str, Any]:
    """Return the fields of a stage for the arena, its obstacles and its robots."""
    task, arena = scenario.task, scenario.arena
    return {
        "scenario": scenario.name,
        "length": arena.length,
        "width": arena.width,
        "start_radius": task.start_radius,
        "robot_radius": scenario.robot.radius,
        "n_robots": task.n_robots,
        "tick": scenario.tick,
        "duration": scenario.n_ticks * scenario.tick,
        "corners": np.array(arena.corners, np.float64).reshape(-1, 2),
        "obstacles": tuple(
            Outline(np.array(each.points, np.float64), each.radius, each.is_closed)
            for each in scenario.obstacles
        ),
        "has_faults": scenario.faults.is_any,
    }


def bodies(world: EpuckWorld, w: int) -> dict[str, Any]:
    """Return the fields of a scene for the robots of one world: poses and received messages."""
    robots = world.robots[w].view(np.recarray)
    has_faults, heard = world.worlds["has_faults"][w], robots.heard
    receiver, slot = np.nonzero(np.arange(heard.sender.shape[1]) < heard.n[:, None])
    return {
        "time": float(world.worlds["ticks"][w]) * world.scenarios[w].tick,
        "pose": robots.pose.copy(),
        "messages": np.stack([heard.sender[receiver, slot], receiver], axis=1).astype(np.int32),
        "faulty": robots.is_faulty.any(axis=1) if has_faults else None,
    }
