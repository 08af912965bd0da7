"""Compiled policy, which observes and acts as a learner does without calls to Python."""

from dataclasses import dataclass

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.compiler import bind
from swarm_forage_env.envs.decision_kernels import observe as observe_all
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.interface import KEEP, REPLACE, Controller, Kernel, PolicyOverLayers
from swarm_forage_env.observed_fields import spans_of, write_fields
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.record import RecordType
from swarm_forage_env.ticks import RUN, START, Arrays

forward: Kernel
observe: Kernel
write_raw: Kernel
command: Kernel
"""Free names of the template: the policy; writing observations and reading actions."""


@dataclass(frozen=True)
class Pilot:
    """Policy of the robots as a kernel with its weights."""

    form: PolicyForm
    """Observation and action of the policy."""
    forward: Kernel
    """Kernel that writes the action of a robot from its observation, the weights, the layer sizes,
    the robot's recurrent state, which is updated, and a scratch array."""
    weights: Float32[Array, " numbers"]
    sizes: Int64[Array, " sizes"]
    n_state: int
    n_between: int
    """Size of the scratch array."""

    def arrays(
        self, n: int, robots: RecordType, minds: RecordType, learners: Int64[Array, " learners"]
    ) -> dict[str, Array]:
        """Return the arrays that the policy of n robots reads and writes, by name.

        `minds` is the type of the estimators' records, or with `learn="everything"` of messages.
        """
        form = self.form
        mind_type = minds if form.config.learn == "everything" else np.dtype([("estimator", minds)])
        known = {"robots": robots, "minds": mind_type}
        n_seen, n_raw, layout = len(form.layout), len(form.policy.action), form.action.layout
        *_, bound, squashes = form.scaling
        return {
            "pilot_spans": spans_of(form.shown, known),
            "pilot_out": spans_of(form.policy.action, known),
            "pilot_robots": learners,
            "pilot_bound": bound,
            "pilot_squashes": squashes.view(np.uint8),
            "pilot_choices": form.action.conversion[0],
            "pilot_numbers": self.weights,
            "pilot_sizes": self.sizes,
            "pilot_states": np.zeros((n, self.n_state), np.float32),
            "pilot_between": np.zeros(self.n_between, np.float32),
            "pilot_actions": np.zeros((1, n, len(layout)), np.float32),
            "pilot_low": np.array([each.low for each in layout], np.float32),
            "pilot_high": np.array([each.high for each in layout], np.float32),
            "pilot_raw": np.zeros((1, n, n_raw), np.float32),
            "pilot_frames": np.zeros((1, n, 0, n_seen), np.float32),
            "pilot_seen": np.zeros((1, n, n_seen), np.float32),
            "pilot_modes": np.zeros(1, np.int8),
            "left_alone": np.full(1, -1, np.int64),
        }

    @property
    def argument_expression(self) -> str:
        """Expression, in the names of these arrays, of the argument `piloting` of `act_as_learner`.

        Its other names are `robot_words`, `mind_words`, `n_robots`, `no_additions` and `time_left`.
        """
        form, action = self.form, self.form.action
        direction, direction_to, has_walk, *_ = form.scaling
        _, n_symmetric, steers_at, by = action.conversion
        weighting = REPLACE if "weighting" in form.policy.replaces else KEEP
        marks = KEEP, False, False
        if "motion" in form.policy.replaces:
            marks = action.motion, action.has_reflexes, form.has_walk
        numbers = ", ".join(str(int(each)) for each in (form.config.period, *marks, weighting))
        words = "robot_words, mind_words, robot_words"
        return (
            f"({words}, pilot_spans, n_robots), ({words}, pilot_out, n_robots), pilot_robots,"
            f" ({direction}, {direction_to}, {has_walk}, pilot_bound, pilot_squashes),"
            " (no_additions, time_left, pilot_raw), (pilot_seen, pilot_frames, pilot_seen),"
            f" (pilot_choices, {n_symmetric}, {steers_at}, {float(by)!r}),"
            " (pilot_numbers, pilot_sizes, pilot_states, pilot_between, pilot_actions, pilot_low,"
            f" pilot_high), ({numbers}, left_alone), pilot_modes"
        )

    @property
    def kernel(self) -> Kernel:
        """`act_as_learner`, bound to this policy."""
        functions = {"forward": self.forward, "observe": bind(observe_all, {})}
        return bind(act_as_learner, {**functions, **self.form.action.functions})


READ_ONLY_ARRAYS = (
    "pilot_spans", "pilot_out", "pilot_robots", "pilot_bound", "pilot_squashes", "pilot_numbers",
    "pilot_sizes", "pilot_low", "pilot_high", "left_alone",
)  # fmt: skip
"""Names of the arrays that a policy only reads."""


def pilot_and_layers(
    controller: Controller, scenario: BaseScenario
) -> tuple[Pilot | None, Controller]:
    """Return the compiled policy or None, and the controller below; ConfigError if not compiled."""
    if not isinstance(controller, PolicyOverLayers):
        return None, controller
    return controller.pilot(scenario), controller.under(scenario)


def act_as_learner(robots: Array, ticks: int, piloting: Arrays) -> None:
    """Write the policy's actions if a decision is due, except for a robot driven by a visitor."""
    fields, out_fields, learners, scaling, extras, rows, form, network, marks, modes = piloting
    numbers, sizes, states, between, actions, low, high = network
    period, motion, has_reflexes, is_walking, weighting, left_alone = marks
    if ticks % period != 0:
        return
    modes[0] = START if ticks == 0 else RUN
    observe(fields, learners, scaling, extras, modes, rows, (0, 1))
    raw, observed = extras[2], rows[2]
    for each in range(learners.shape[0]):
        i = learners[each]
        if ticks == 0:
            states[each, :] = 0.0
        forward(observed[0, each], numbers, sizes, states[each], between, actions[0, each])
        for k in range(low.shape[0]):
            actions[0, each, k] = min(max(actions[0, each, k], low[k]), high[k])
        write_raw(actions, 0, each, form, raw[0, each])
        if i != left_alone[0]:
            action = robots[0, i].action
            action.motion, action.weighting = motion, weighting
            action.has_reflexes, action.is_walking = has_reflexes, is_walking
            write_fields(raw[0, each], out_fields, 0, i)
