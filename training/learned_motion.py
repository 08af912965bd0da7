"""A learned motion: the few weights of `training.linear_motion_policy`, from a policy file."""

from pathlib import Path
from typing import Any

from pydantic import Field

from baselines.motion.base import MOTIONS
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.parameters import Part
from swarm_forage_env.task import task_of
from training.linear_motion_policy import linear_motion, linear_policy_of
from training.policy_file import load_policy, policy_path


@MOTIONS.register("learned")
class LearnedMotion(Part):
    """A trained policy corrects the motion. Not in the papers: all of it."""

    policy: str = Field(
        "motion", description="The weights: a bundled policy, or a file as runs/x/best.safetensors"
    )

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files, other than source code, that its output depends on."""
        return (policy_path(self.policy),)

    def check_usable(self, scenario: Any = None) -> None:  # noqa: ANN401 of any task
        """ConfigError or UnknownNameError if the policy is missing or does not fit."""
        policy = load_policy(self.policy)
        if scenario is not None and task_of(scenario).name == "foraging":
            policy.check_fits("motion", scenario)
        linear_policy_of(policy)

    def layer(self, scenario: Scenario) -> MotionLayer:
        """The compiled motion; ConfigError if the policy does not fit."""
        policy = load_policy(self.policy)
        policy.check_fits("motion", scenario)
        return linear_motion(linear_policy_of(policy), scenario)
