"""Observations: what the learned layer is shown, additions to it, and ones of the user's own.

An observation of the user's own is a class that names its features and writes them, in SI units,
from the records of a block of worlds:

    class Heading:
        def features(self, scenario, agents):
            return [Feature("heading", "rad", -math.pi, math.pi)]

        def write(self, context, out):
            out[:, :, 0] = context.robots["pose"][:, :, 2]

`parallel_env("es1", observation=["layer", Heading])` shows it beside what the layer sees.
"""

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Float32, Float64, Int64, read_only
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs.decision_kernels import Scaling, normalise_row, observe
from swarm_forage_env.envs.extra_observations import (
    OBSERVATIONS,
    Observation,
    ObservationContext,
    RowObservation,
    previous_action,
)
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.observed_fields import FieldLayout
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.policy_interface import PolicyInterface
from swarm_forage_env.random_streams import hash_of
from swarm_forage_env.registry import left_out
from swarm_forage_env.spaces import Feature, Layout
from swarm_forage_env.ticks import BEGINS, STANDS, Modes
from swarm_forage_env.worlds_on_cpu import PlacedArray, WorldsOnCpu

LAYER = "layer"
"""The name of what the learned layer is shown."""

PREVIOUS = "previous_action"

Place = WorldsOnCpu | DeviceLoop
"""Worlds where they run."""

Addition = Observation | RowObservation
"""What is observed beside the layer: by name, or a class of the user's own."""


def added(observation: object, policy: PolicyInterface) -> tuple[bool, list[Addition]]:
    """Whether what the layer sees is shown, and what is shown beside it.

    ConfigError or UnknownNameError for what is no observation.
    """
    wanted = list(observation) if isinstance(observation, list | tuple) else [observation]
    if not wanted:
        raise ConfigError("observation=[]: must name something; leave it out for the layer's own")
    additions: list[Addition] = []
    for each in wanted:
        if not isinstance(each, str):
            additions.append(_own(each))
        elif each == PREVIOUS:
            additions.append(previous_action(policy.action))
        elif each != LAYER and each not in OBSERVATIONS:
            known = LAYER, PREVIOUS, *OBSERVATIONS
            raise UnknownNameError("observation", each, known, left_out())
        elif each != LAYER:
            additions.append(OBSERVATIONS[each])
    return LAYER in [each for each in wanted if isinstance(each, str)], additions


def _own(observation: object) -> Observation:
    made = observation() if isinstance(observation, type) else observation
    if not isinstance(made, Observation):
        raise ConfigError(
            f"observation={observation!r}: must be '{LAYER}', '{PREVIOUS}', a name of"
            f" {', '.join(OBSERVATIONS)}, or a class with `features` and `write`"
        )
    return made


def normalised(layout: Layout) -> Layout:
    """The same features as shares of their typical sizes, within [-1, 1]."""
    return Layout(
        Feature(each.name, _unit_of(each), -1.0 if each.low < 0.0 else 0.0, 1.0, each.noise)
        for each in layout
    )


def _unit_of(feature: Feature) -> str:
    if feature.scale is not None:
        return f"x / (|x| + {feature.scale:g}), x in {feature.unit or '1'}"
    return feature.unit if feature.bound == 1.0 else f"of {feature.bound:.4g} {feature.unit}"


class Normaliser:
    """Brings numbers in SI units into [-1, 1].

    x / (|x| + s)       of typical size s
    x / b               within bounds of +- b that are typical themselves
    """

    def __init__(self, layout: Layout) -> None:
        for each in layout:
            if each.scale is None and not 0.0 < each.bound < np.inf:
                raise ConfigError(
                    f"observation {each.name}: bounds of {each.low:g} to {each.high:g} tell no"
                    " typical size; give the feature a scale, or take normalise=False"
                )
        self.bound = np.array(
            [each.bound if each.scale is None else each.scale for each in layout], np.float32
        )
        self.squashes = np.array([each.scale is not None for each in layout])

    def __call__(self, numbers: Float32[Array, "*any numbers"]) -> None:
        """Normalise numbers in place."""
        normalise_rows(numbers.reshape(-1, len(self.bound)), self.bound, self.squashes)


@entry_point
def normalise_rows(
    rows: Float32[Array, "rows numbers"], bound: Float32[Array, " numbers"], squashes: Array
) -> None:
    """Normalise every row."""
    for i in range(rows.shape[0]):
        normalise_row(rows[i], bound, squashes)


class Observer:
    """What a policy observes: the layout of its numbers, and what writes them."""

    def __init__(
        self,
        policy: PolicyInterface,
        observation: object,
        shown: FieldLayout,
        scenario: BaseScenario,
        agents: Sequence[str],
        normalise: bool,
    ) -> None:
        """`shown` is what the layer sees, `observation` what a policy observes of it and beside."""
        has_layer, self.parts = added(observation, policy)
        """Whether what the layer sees is observed; and what is observed beside it."""
        self.shown = shown if has_layer else FieldLayout((), (), shown.sizes)
        layout: Layout = self.shown
        self._direction, has_walk = -1, bool(policy.walk) and shown.paths[-1:] == policy.walk
        self._has_walk = has_walk
        if (normalise or has_walk) and has_layer and policy.target is not None:
            self._direction = layout.names.index(f"{policy.target}.x")
            if not has_walk:
                layout = Layout((*layout, *_directions(policy.target)))
        self._direction_to = len(layout) - 2
        self.features: list[tuple[int, Layout]] = []
        """Where the numbers of each of the parts begin, and what they are."""
        for part in self.parts:
            features = _checked_features(part, scenario, agents)
            self.features.append((len(layout), features))
            layout = layout if not features else Layout((*layout, *features))
        _check_names(layout)
        self._normalise = Normaliser(layout) if normalise else None
        self.layout = normalised(layout) if normalise else layout
        """What each number is."""

    @property
    def scaling(self) -> Scaling:
        """How observations are scaled, as `decision_kernels.observe` takes it."""
        where = self._direction, self._direction_to, self._has_walk
        if self._normalise is None:
            return *where, np.zeros(0, np.float32), np.zeros(0, np.bool_)
        return *where, self._normalise.bound, self._normalise.squashes


class Observing:
    """Writes what some robots of the worlds of a place observe, a new array each time."""

    def __init__(
        self, observer: Observer, place: Place, robots: Int64[Array, " learners"], stack: int
    ) -> None:
        self._observer, self._place, memory = observer, place, place.memory
        self._shape = place.arrays["robots"].shape
        rows = self._shape[0], len(robots)
        self._robots, self._learners = robots, memory.to_device(robots)
        self._seen = *rows, len(observer.layout)
        self._stacked = *rows, stack * len(observer.layout)
        frames = np.zeros((*rows, stack if stack > 1 else 0, len(observer.layout)), np.float32)
        self._kept = memory.to_device(frames)
        *where, bound, squashes = observer.scaling
        self._scaling = *where, memory.to_device(bound), memory.to_device(squashes)
        self._fields = place.fields(observer.shown)
        self._numpy: list[tuple[Observation, int, Layout, Box]] = []
        additions: list[tuple[int, int]] = []
        for part, (first, features) in zip(observer.parts, observer.features, strict=True):
            if isinstance(part, RowObservation):
                additions.append((part.which, first))
            else:
                self._numpy.append((part, first, features, features.box()))
        self._additions = memory.to_device(np.array(additions, np.int64).reshape(-1, 2))
        self._none = memory.to_device(np.zeros(rows[0]))
        self._streams = np.zeros(self._shape if self._numpy else (0, 0), np.uint64)
        self._observe = place.kernel(observe, {})

    def __call__(
        self,
        raw: PlacedArray,
        modes: PlacedArray,
        time_left: Callable[[], Float64[Array, " worlds"]],
    ) -> Any:  # noqa: ANN401 an array of NumPy, or of a GPU
        """What every robot observes after these actions, as the layers took them.

        Of a world that BEGINS the action is forgotten, and its frames are the first observation;
        to those of a world that RUNS one is added. The share of the episode that is left is asked
        for where something is observed beside the layer.
        """
        memory, left = self._place.memory, self._none
        seen, out = self.room()
        if self._observer.parts:
            share = time_left()
            left = memory.to_device(share)
            if self._numpy:
                self._add_all(share, cast(Array, raw), cast(Array, modes), cast(Array, seen))
        beside = self._additions, left, raw
        rows = seen, self._kept, out
        self._observe(self._fields, self._learners, self._scaling, beside, modes, rows)
        return out

    def room(self, *axes: int) -> tuple[PlacedArray, PlacedArray]:
        """New arrays for what is observed, without and with the frames before; or one for both."""
        empty, n_frames = self._place.memory.empty, self._kept.shape[2]
        seen = empty((*axes, *self._seen), np.float32)
        return seen, empty((*axes, *self._stacked), np.float32) if n_frames else seen

    @property
    def handed(self) -> tuple[Any, ...]:
        """Where observations lie, how they are scaled, what is beside them, and frames."""
        return self._fields, self._scaling, self._additions, self._kept

    def snapshot(self) -> tuple[Array, Array]:
        """The frames and the streams: what a later `restore` needs."""
        return np.array(self._place.memory.read(self._kept)), self._streams.copy()

    def fits(self, kept: tuple[Array, Array]) -> bool:
        """The snapshot is of as many worlds, robots, observations and numbers."""
        frames, streams = kept
        return bool(frames.shape == self._kept.shape and streams.shape == self._streams.shape)

    def restore(self, kept: tuple[Array, Array]) -> None:
        """Go on as when the snapshot was taken."""
        frames, self._streams[...] = kept
        self._place.memory.write(self._kept, frames)

    def _add_all(
        self,
        share: Float64[Array, " worlds"],
        raw: Float32[Array, "worlds learners numbers"],
        modes: Modes,
        seen: Float32[Array, "worlds learners numbers"],
    ) -> None:
        """Write what the classes of the user's own observe; ConfigError for a wrong number."""
        at, begins = self._place.arrays, modes == BEGINS
        # the streams of new episodes derive from those of the robots, which follow the seed
        self._streams[begins] = at["robots"]["streams"][begins, :, 0] ^ hash_of("observation")
        raw[begins] = 0.0
        actions = np.zeros((*self._shape, raw.shape[2]), np.float32)
        actions[:, self._robots] = raw
        minds = cast("Array | None", self._place.estimators)
        context = ObservationContext(
            robots=read_only(at["robots"]),
            worlds=read_only(at["worlds"]),
            minds=None if minds is None else read_only(minds),
            time_left=share,
            last_action=actions,
            streams=self._streams,
            is_observed=modes != STANDS,
        )
        for part, first, features, box in self._numpy:
            out = np.zeros((*self._shape, len(features)), np.float32)
            returned = cast(Any, part).write(context, out)
            if returned is not None and returned is not out:
                raise ConfigError(
                    f"observation {type(part).__name__}: `write` returned numbers, must write them"
                    " into `out`, as out[:, :, 0] = ...; what it does not write is zero"
                )
            seen[:, :, first : first + len(features)] = own = out[:, self._robots]
            _check_numbers(own, features, box)


def stacked(layout: Layout, n: int) -> Layout:
    """The layout of the last n observations, the oldest first."""
    if n == 1:
        return layout
    ages = [f"{n - 1 - k} ago." if k < n - 1 else "" for k in range(n)]
    return Layout(
        Feature(age + each.name, each.unit, each.low, each.high, each.noise)
        for age in ages
        for each in layout
    )


def _directions(target: str) -> list[Feature]:
    return [Feature(f"{target}.direction.{axis}", "ratio", -1.0, 1.0) for axis in "xy"]


def _check_names(layout: Layout) -> None:
    names = layout.names
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice or not names:
        raise ConfigError(f"observation: must have features of different names; twice: {twice}")


def _checked_features(part: Addition, scenario: BaseScenario, agents: Sequence[str]) -> Layout:
    """What an addition says its numbers are; ConfigError for what are no features."""
    items: object = part.features(scenario, agents)
    if not isinstance(items, Sequence) or not all(isinstance(each, Feature) for each in items):
        raise ConfigError(
            f"observation {type(part).__name__}: features gave {items!r}, must be a list of Feature"
        )
    return Layout(items)


def _check_numbers(
    numbers: Float32[Array, "worlds learners numbers"], features: Layout, box: Box
) -> None:
    """ConfigError for a number of an observation of the user's own outside its bounds, or NaN."""
    is_right = (box.low <= numbers) & (numbers <= box.high) & np.isfinite(numbers)
    if not is_right.all():
        world, robot, k = map(int, np.argwhere(~is_right)[0])
        low, high = features[k].low, features[k].high
        raise ConfigError(
            f"observation {features[k].name}: is {numbers[world, robot, k]} for learner {robot} of"
            f" world {world}, must be a finite number of {low:g} to {high:g}; mend `write`, or its"
            " bounds"
        )
