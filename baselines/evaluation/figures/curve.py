"""A metric over one number of the scenario or of the controller: beta, the size of the group."""

import json
import logging
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from baselines.evaluation.catalogue import units
from baselines.evaluation.curves import Means, mean_panels
from baselines.evaluation.figures.base import FIGURES, SELECTION, Wish, counted, sample
from baselines.evaluation.groups import Group
from baselines.evaluation.statistics import mean_interval
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.scenario import resolve

LOGGER = logging.getLogger("swarm-forage")

Series = dict[tuple[str, str], list[Group]]
"""Groups that differ in x alone, by setup and controller without x."""


class OverNumber:
    """Means with intervals over x; a controller that does not have x is a level line."""

    options = SELECTION | {"metric", "x"}

    def draw(self, wish: Wish) -> Figure:
        """A curve for each controller, a panel for each setup."""
        x = _named(wish.x, wish.groups) if wish.x else _found(wish.groups)
        having = [group for group in wish.groups if x in group.numbers]
        panels = _panels(wish, having, x)
        ends = [float(group.numbers[x]) for group in having]
        for group in wish.groups:
            if group not in having and group.setup() in panels:
                level = _level(wish, group, (min(ends), max(ends)))
                panels[group.setup()][group.label()] = level
        head = having[0]
        axes = _axis(x, head), head.kind.axis(wish.shown)
        text = f"Means with 95 % bootstrap intervals (BCa). {counted(wish.groups)}"
        return mean_panels(panels, axes, wish.caption(text))


FIGURES.register("curve")(OverNumber())


def _panels(wish: Wish, groups: Sequence[Group], x: str) -> dict[str, dict[str, Means]]:
    """The curves of each setup; ConfigError if x varies in none, a line on stderr if in some."""
    setups: dict[str, dict[str, list[Group]]] = {}
    for (setup, label), listed in _series(groups, x).items():
        setups.setdefault(setup, {})[label] = listed
    short = [setup for setup, each in setups.items() if max(map(len, each.values())) < 2]
    if len(short) == len(setups):
        raise ConfigError(_too_few(x, groups))
    for setup in short:
        LOGGER.warning("left out, as %s does not vary there: %s", x, setup)
    return {
        setup: {label: _means(wish, listed, x) for label, listed in each.items()}
        for setup, each in setups.items()
        if setup not in short
    }


def _named(name: str, groups: Sequence[Group]) -> str:
    """The number that is meant by `beta` or `weighting.beta`."""
    known: dict[str, Any] = {}
    for group in groups:
        known |= _numeric(group)
    return resolve(name, known, "number behind these episodes")


def _found(groups: Sequence[Group]) -> str:
    """The one number that varies while all else is the same; ConfigError if it is not one."""
    candidates = {name for group in groups for name in _numeric(group)}
    vary = {name for name in candidates if len({group.numbers.get(name) for group in groups}) > 1}
    found = []
    for name in sorted(vary):
        having = [group for group in groups if name in group.numbers]
        if max(map(len, _series(having, name).values())) > 1:
            found.append(name)
    if len(found) == 1:
        return found[0]
    if found:
        raise ConfigError(f"several numbers vary: choose one with --x {' or --x '.join(found)}")
    raise ConfigError(_too_few("number", groups))


def _too_few(x: str, groups: Sequence[Group]) -> str:
    held = ", ".join(dict.fromkeys(f"{each.scenario} {each.label()}" for each in groups))
    return (
        f"no {x} takes two values while all else is the same ({held}); evaluate some, as in"
        " swarm-forage evaluate es1 ssgiff:beta=0.001 ssgiff:beta=0.01, or with"
        " --set task.n_robots=5 and --set task.n_robots=10 into one folder"
    )


def _numeric(group: Group) -> dict[str, Any]:
    return {
        name: value
        for name, value in group.numbers.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }


def _series(groups: Sequence[Group], x: str) -> Series:
    """The groups by what they share, ordered by x; the scenario's name may differ with x."""
    shared: dict[str, list[Group]] = {}
    for group in groups:
        rest = {name: value for name, value in group.numbers.items() if name not in (x, "name")}
        key = json.dumps([group.controller, group.physics, rest], sort_keys=True)
        shared.setdefault(key, []).append(group)
    series: Series = {}
    for each in shared.values():
        ordered = sorted(each, key=lambda group: float(group.numbers[x]))
        setups = list(dict.fromkeys(group.setup(x) for group in ordered))
        title = setups[0] if len(setups) == 1 else f"{setups[0]} to {setups[-1]}"
        series.setdefault((title, ordered[0].label(x)), []).extend(ordered)
    return series


def _means(wish: Wish, groups: Sequence[Group], x: str) -> Means:
    rows = [(float(group.numbers[x]), *_mean(wish, group)) for group in groups]
    at, mean, low, high = np.array(rows).T
    return Means(at, mean, low, high)


def _level(wish: Wish, group: Group, ends: tuple[float, float]) -> Means:
    mean, low, high = (np.full(2, value) for value in _mean(wish, group))
    return Means(np.array(ends), mean, low, high, is_level=True)


def _mean(wish: Wish, group: Group) -> tuple[float, float, float]:
    """Mean and interval, which is the mean itself where nothing varies; NaN for no value."""
    found = mean_interval(sample(group, wish.shown))
    if found is None:
        return np.nan, np.nan, np.nan
    low, high = found.interval or (found.value, found.value)
    return found.value, low, high


def _axis(x: str, group: Group) -> str:
    """The number with its unit, if there is still such a controller to tell it."""
    try:
        configuration = group.configuration()
        unit = (units(configuration.scenario) | units(configuration.recipe)).get(x, "")
    except (ConfigError, UnknownNameError):
        unit = ""
    name = x.rpartition(".")[2].replace("n_robots", "robots").replace("_", " ")
    return f"{name} [{unit}]" if unit else name
