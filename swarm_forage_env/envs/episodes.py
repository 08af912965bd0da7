"""Episodes of a block of worlds: seeds, randomised parameters and lengths."""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded

from swarm_forage_env.arrays import Array, Bool, Float64, Int64, UInt64
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.errors import ConfigError, shown
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import MAX_TICKS, BaseScenario, leaves, override, resolve
from swarm_forage_env.random_streams import (
    checked_seed,
    draw_seeds,
    generator_of,
    start_seed_streams,
)
from swarm_forage_env.randomise import Randomisation
from swarm_forage_env.task import chosen_worlds

Seeds = int | Sequence[int | None] | None
"""One seed, so that the worlds take seed, seed + 1 and so on; or one seed for each world."""

FIXED_PARAMETERS = frozenset({"name", "tick", "task.duration"})
"""Parameters that cannot differ between episodes, in addition to those of `BaseScenario.fixed`."""

TESTED_OPTION = "options"
"""Option that PettingZoo's tests pass to every environment; it is ignored."""

OPTION = "scenario parameter for an episode"

NOT_BEGUN = "the episode has not begun: call reset() first"


class Episodes:
    """Current episode of each world of a loop."""

    def __init__(
        self,
        loop: Loop | DeviceLoop,
        randomisation: Randomisation,
        check_scenario: Callable[[BaseScenario], None],
    ) -> None:
        """`check_scenario` refuses options with which an environment cannot run an episode."""
        self._loop, self._scenario = loop, randomisation.scenario
        self._randomisation, self._check_scenario = randomisation, check_scenario
        for name in FIXED_PARAMETERS.intersection(randomisation.ranges):
            raise ConfigError(f"randomise: {name} is the same in all episodes; leave it out")
        n_worlds = loop.world.n_worlds
        self.drawn: dict[str, Float64[Array, " worlds"]] = {
            name: np.zeros(n_worlds) for name in randomisation.ranges
        }
        """Randomised parameters of each world's episode, by name."""
        self.streams: UInt64[Array, "worlds 4"] = np.zeros((n_worlds, 4), np.uint64)
        """Random stream of each world, in the format of `pcg64`, for seeds that are not given."""
        self._roots: UInt64[Array, " worlds"] = np.zeros(n_worlds, np.uint64)
        self.steps: Int64[Array, " worlds"] = np.zeros(n_worlds, np.int64)
        """Decisions (with `step_on="exchange"` ticks) since the episode of each world began."""
        self.ends: Int64[Array, " worlds"] = np.zeros(n_worlds, np.int64)
        """Value of `steps` at which each episode ends; 0 before the first episode."""
        self.is_interrupted = np.zeros(n_worlds, np.bool_)
        """Worlds whose last step or reset an exception cut short, as one in a user's reward."""
        self.needs_upload = False
        """Whether streams or counts were changed on the CPU and not yet copied to the GPU."""
        self._is_other = np.zeros(n_worlds, np.bool_)
        self._is_seeded = np.zeros(n_worlds, np.bool_)
        self.seed([None] * n_worlds)

    @property
    def generators(self) -> list[np.random.Generator]:
        """Copies of the streams as NumPy generators that draw the same values."""
        return [*map(generator_of, self._roots.tolist(), self.streams)]

    def drawn_in(self, world: int) -> dict[str, float]:
        """Return the randomised parameters of a world's episode, by name."""
        return {name: float(each[world]) for name, each in self.drawn.items()}

    @property
    def is_over(self) -> Bool[Array, " worlds"]:
        """Whether the episode of each world has ended, so that it must be reset."""
        return np.asarray((self.ends > 0) & (self.steps >= self.ends))

    @property
    def share_gone(self) -> Float64[Array, " worlds"]:
        """Elapsed share of the episode of each world."""
        return np.asarray(np.minimum(self.steps / np.maximum(self.ends, 1), 1.0))

    @property
    def share_left(self) -> Float64[Array, " worlds"]:
        """Remaining share of the episode of each world."""
        return np.asarray(1.0 - self.share_gone)

    @property
    def has_begun(self) -> bool:
        """Whether the episode of any world has begun."""
        return bool(self.ends.any())

    @property
    def is_unseeded(self) -> Bool[Array, " worlds"]:
        """Whether each world has neither a seed nor an episode yet."""
        return np.asarray(~self._is_seeded & (self.ends == 0))

    def check_begun(self) -> None:
        """Raise ResetNeeded if no episode has begun."""
        if not self.has_begun:
            raise ResetNeeded(NOT_BEGUN)

    def check_running(self, limit: int = MAX_TICKS) -> None:
        """Raise ResetNeeded if an episode has not begun, has ended, has reached the limit, or was
        interrupted."""
        needs_reset = self.is_interrupted | (self.steps >= np.minimum(self.ends, limit))
        if not needs_reset.any():
            return
        if not self.ends.all():
            raise ResetNeeded(NOT_BEGUN)
        world = int(np.flatnonzero(needs_reset)[0])
        where = "" if len(self.ends) == 1 else f" of world {world}"
        why = f"step after the end{where}, at {self.steps[world]} cycles"
        if self.is_interrupted[world]:
            why = f"the last step or reset{where} was interrupted by an exception"
        raise ResetNeeded(f"{why}: call reset() first")

    def begin(
        self, seed: Seeds, worlds: object, options: Mapping[str, object], n_steps: int
    ) -> Int64[Array, " chosen"]:
        """Reset worlds for `n_steps` decisions; return their indices. ConfigError changes none."""
        chosen = chosen_worlds(worlds, len(self.ends))
        seeds = checked_seeds(seed, len(chosen))
        base, usual = self.scenario_under(options), self._randomisation
        drawn = usual if base is self._scenario else Randomisation(base, usual.ranges)
        own = self._drawn_where_none(seeds, chosen).tolist()
        scenarios, numbers = zip(*map(drawn.draw, own), strict=True) if own else ((), ())
        before = tuple(self._loop.world.scenarios[world] for world in chosen)
        self._loop.reset(own, chosen.tolist(), None if scenarios == before else scenarios)
        for name, values in self.drawn.items():
            values[chosen] = [each[name] for each in numbers]
        self.steps[chosen], self.ends[chosen] = 0, n_steps
        self._is_other[chosen], self.needs_upload = base is not self._scenario, True
        self.is_interrupted[chosen] = True  # until it is observed
        return chosen

    @property
    def are_alike(self) -> bool:
        """Whether successive episodes differ in their seeds only."""
        return not self.drawn and not self._is_other.any()

    def follow_on(self, n_steps: int) -> Bool[Array, " worlds"]:
        """Count the episodes that a GPU has begun; return the worlds where one was over."""
        over = self.is_over
        ended = np.flatnonzero(over)
        draw_seeds(ended, self.streams, np.zeros(len(ended), np.uint64))
        self.steps[ended], self.ends[ended] = 0, n_steps
        return over

    def seed(self, seeds: Sequence[int | None]) -> None:
        """Start the seed stream of each world; None: from entropy of the operating system."""
        is_given = [own is not None for own in seeds]
        if None in seeds:
            unknown = entropy(len(seeds)).tolist()
            seeds = [new if own is None else own for own, new in zip(seeds, unknown, strict=True)]
        self._start(np.asarray(seeds, np.uint64), np.arange(len(seeds)))
        self._is_seeded[:] = is_given

    def seed_anew(self, is_chosen: Bool[Array, " worlds"]) -> None:
        """Start the seed streams of these worlds from entropy, as a copy of unseeded worlds does.

        Copies with the stream of the original would all play the same episodes.
        """
        chosen = np.flatnonzero(is_chosen)
        self._start(entropy(len(chosen)), chosen)
        self._is_seeded[chosen] = False

    def stagger(self) -> None:
        """Spread the ends of the current episodes evenly over their length."""
        share = np.arange(1, len(self.ends) + 1) / len(self.ends)
        self.ends[:] = np.ceil(share * self.ends)
        self.needs_upload = True

    def snapshot(self) -> object:
        """Return a copy of the state, for `restore`."""
        return deepcopy((self.drawn, self._numbers))

    def restore(self, snapshot: object) -> None:
        """Continue from a snapshot."""
        self.drawn, numbers = deepcopy(parts_of(snapshot, 2))
        for here, saved in zip(self._numbers, numbers, strict=True):
            here[...] = saved
        self._is_seeded[:] = True
        self.needs_upload = True

    @property
    def _numbers(self) -> tuple[Array, ...]:
        counts = self.steps, self.ends
        return self.streams, self._roots, *counts, self._is_other, self.is_interrupted

    def scenario_under(self, options: Mapping[str, object]) -> BaseScenario:
        """Return the scenario of an episode with these options; ConfigError if one does not fit."""
        numbers = {name: value for name, value in options.items() if name != TESTED_OPTION}
        known = leaves(self._scenario.model_dump()) if numbers else {}
        for name in numbers:
            path = resolve(name, known, OPTION)
            is_fixed = path in FIXED_PARAMETERS.union(self._scenario.fixed)
            if is_fixed or path in self.drawn:
                why = "is the same in all episodes" if is_fixed else "is randomised"
                raise ConfigError(f"options['{name}']: {why}; set it when the environment is made")
        scenario = override(self._scenario, numbers, OPTION)
        if numbers:
            self._check_scenario(scenario)
        return scenario

    def _start(self, seeds: UInt64[Array, " chosen"], chosen: Int64[Array, " chosen"]) -> None:
        self._roots[chosen], self.needs_upload = seeds, True
        start_seed_streams(seeds, chosen, self.streams)

    def _drawn_where_none(
        self, given: Sequence[int | None], chosen: Int64[Array, " chosen"]
    ) -> UInt64[Array, " chosen"]:
        is_given = np.array([each is not None for each in given], np.bool_)
        seeds = np.array([each or 0 for each in given], np.uint64)
        self._start(seeds[is_given], chosen[is_given])
        others = np.zeros(len(chosen) - is_given.sum(), np.uint64)
        draw_seeds(chosen[~is_given], self.streams, others)
        seeds[~is_given] = others
        return seeds


def entropy(n: int) -> UInt64[Array, " n"]:
    """Return n seeds from entropy of the operating system."""
    return np.random.SeedSequence().generate_state(n, np.uint64)


def checked_options(options: object) -> Mapping[str, object]:
    """Return the options of a reset; ConfigError unless they are a mapping by name."""
    if options is None:
        return {}
    if isinstance(options, Mapping) and all(isinstance(name, str) for name in options):
        return options
    raise ConfigError(
        f"options={shown(options)}: must be a dictionary of scenario parameters, such as"
        " {'radio.max_range': 0.2}"
    )


def parts_of(snapshot: object, n_parts: int) -> tuple[Any, ...]:
    """Return the parts of a snapshot; ConfigError if it is not a tuple of `n_parts`."""
    if isinstance(snapshot, tuple) and len(snapshot) == n_parts:
        return snapshot
    raise ConfigError("restore(): must be given the result of snapshot() of such an environment")


def checked_seeds(seed: Seeds, n: int) -> Sequence[int | None]:
    """Return a checked seed or None for each of n worlds; ConfigError for an invalid seed."""
    if seed is None:
        return [None] * n
    is_single = isinstance(seed, np.ndarray) and seed.ndim == 0
    if is_single or not isinstance(seed, Sequence | np.ndarray) or isinstance(seed, str):
        first = checked_seed(seed)
        if first + n > 2**64:
            raise ConfigError(f"seed={first}: {n} worlds count up from it, past 2^64 - 1")
        return range(first, first + n)
    if len(seed) != n:
        raise ConfigError(f"seed={shown(seed)}: must be {n} seeds, one for each world")
    return [None if own is None else checked_seed(own) for own in seed]
