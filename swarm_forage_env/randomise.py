"""Randomisation: parameters of a scenario that are drawn from ranges for every episode."""

import math
from collections.abc import Iterator, Mapping
from itertools import product
from numbers import Integral, Real

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.equations import random_draws
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import BaseScenario, leaves, override, resolve
from swarm_forage_env.random_streams import NoiseSource, checked_seed, hash_of, streams

Number = int | float

MAX_TOGETHER = 8
"""Largest number of ranges whose corners are all checked; of more ranges, some are."""

draw_unit = entry_point(random_draws.unit)


class Randomisation:
    """A scenario and ranges for some of its parameters.

    The value of a parameter depends only on the seed of the episode and on its name: not on earlier
    episodes, nor on the other ranges.
    """

    def __init__(self, scenario: BaseScenario, ranges: Mapping[str, object]) -> None:
        """Set the ranges (low, high), by dotted name or, where that is unique, by its last word.

        UnknownNameError for a name that is no parameter of the scenario, ConfigError for an invalid
        range or one with values that the scenario refuses.
        """
        self.scenario = scenario
        self.ranges: dict[str, tuple[Number, Number]] = {}
        """Low and high of each parameter, by its full dotted name."""
        known = leaves(scenario.model_dump())
        for key, pair in ranges.items():
            name = resolve(key, known, "scenario parameter")
            if name in self.ranges:
                raise ConfigError(f"randomise: {name} is given twice, once as '{key}'")
            if name in scenario.unread:
                raise ConfigError(
                    f"randomise: {name} has no effect in '{scenario.name}', which uses"
                    f" {scenario.unread[name]} instead; leave it out"
                )
            _check_is_free(name, known[name], scenario.fixed)
            self.ranges[name] = _pair(name, pair, known[name])
        self.extremes = [scenario, *map(self._at, _corners(self.ranges))]
        """The scenario itself, and with the parameters at the corners of the ranges."""

    def draw(self, seed: int) -> tuple[BaseScenario, dict[str, Number]]:
        """Return the scenario of the episode with this seed, and the values drawn for it.

        Each value is uniform from low to high; whole numbers include both ends.
        """
        if not self.ranges:
            return self.scenario, {}
        word = streams([checked_seed(seed)], 1, NoiseSource.SCENARIO)
        numbers = {name: _drawn(word ^ hash_of(name), *pair) for name, pair in self.ranges.items()}
        return self._at(numbers), numbers

    def _at(self, numbers: Mapping[str, Number]) -> BaseScenario:
        """Return the scenario with these values; ConfigError, which names them, if it refuses."""
        try:
            return override(self.scenario, numbers, "scenario parameter")
        except ConfigError as error:
            at = ", ".join(f"{name}={number}" for name, number in numbers.items())
            raise ConfigError(f"randomise, at {at}: {error}") from None


def _check_is_free(name: str, value: object, fixed: tuple[str, ...]) -> None:
    if name in fixed:
        raise ConfigError(
            f"randomise: {name} determines the sizes of a world's records and must be the same"
            " in all episodes; make an environment for each value"
        )
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"randomise: {name}={value!r} is no number; only numbers are drawn")


def _pair(name: str, pair: object, value: Number) -> tuple[Number, Number]:
    is_whole = isinstance(value, int)
    wanted, kind = ("two whole numbers", Integral) if is_whole else ("two numbers", Real)
    ends = pair if isinstance(pair, tuple | list) else ()
    if len(ends) != 2 or any(isinstance(end, bool) or not isinstance(end, kind) for end in ends):
        raise ConfigError(f"randomise: {name}={pair!r}: must be {wanted}, low and high")
    low, high = map(type(value), ends)
    if not low <= high:
        raise ConfigError(f"randomise: {name}={pair!r}: low must be at most high")
    return low, high


def _corners(ranges: Mapping[str, tuple[Number, Number]]) -> Iterator[dict[str, Number]]:
    """Yield the ends of the ranges: each alone, then together."""
    for name, pair in ranges.items():
        for end in pair:
            yield {name: end}
    every, ends_alike = product(*ranges.values()), zip(*ranges.values(), strict=True)
    together = every if 0 < len(ranges) <= MAX_TOGETHER else ends_alike
    for ends in together:
        yield dict(zip(ranges, ends, strict=True))


def _drawn(word: Array, low: Number, high: Number) -> Number:
    u = float(draw_unit(word, 0))
    if isinstance(low, int) and isinstance(high, int):
        return min(low + math.floor(u * (high - low + 1)), high)
    return min(low + u * (high - low), high)
