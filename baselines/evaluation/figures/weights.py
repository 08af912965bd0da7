"""Heat maps of a confidence weighting: g over the own and the heard path since an area."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from baselines.controller import LayeredController
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.evaluation.experiment_config import find_layered_controller
from baselines.evaluation.figures.base import PlotOptions, figure
from baselines.evaluation.heat_maps import weight_panels
from baselines.weighting.rows import RowWeighting
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import PolicyOverLayers

LONGEST, STEPS = 12.0, 61
"""Longest path of the robot and of its partner [m], and number of points along each."""

DISAGREEMENTS = (0.1, 0.5)  # distances of own and heard estimate [m]; one row of maps for each

MESSAGES, RANGE, AWAY = 8.0, 0.1, 0.75
"""Number of averaged messages, as in es1; distance of the partner and of both estimates [m]."""

PREY = 1  # the area that the exchange is about


@figure("weights")
def draw(options: PlotOptions) -> Figure:
    """Draw the weights of the controllers in `sources`; ConfigError for one without paths."""
    maps = {
        f"{100 * apart:g} cm apart": {name: _map(name, apart) for name in options.sources}
        for apart in DISAGREEMENTS
    }
    text = (
        f"g: share of the heard estimate, for an exchange of {MESSAGES:g} messages over"
        f" {100 * RANGE:g} cm about the area that the robot heads for, {AWAY:g} m ahead;"
        " it left the other area a quarter of its path ago. Paths since the area; the titles"
        " say how far apart the own and the heard place lie."
    )
    return weight_panels(maps, LONGEST, options.caption(text))


def _map(name: str, apart: float) -> Float64[Array, "heard own"]:
    """Return the weight g over the partner's path (rows) and the own path (columns)."""
    controller = find_layered_controller(name)
    policies = controller.policies.values() if isinstance(controller, PolicyOverLayers) else ()
    if any(getattr(policy, "learn", None) != "motion" for policy in policies):
        raise ConfigError(
            f"controller '{name}': a policy replaces its weighting, which 'weights' cannot show;"
            " name a rule, such as ssgikf, ssgiff or learned-weighting"
        )
    if type(controller.estimator) is not SocialOdometryParameters:
        raise ConfigError(
            f"controller '{controller.name}': its confidence is not a path; 'weights' shows"
            " rules that compare paths, such as ssgikf, ssgiff or learned-weighting"
        )
    grid = np.linspace(0.0, LONGEST, STEPS)
    own, heard = (each.ravel() for each in np.meshgrid(grid, grid))
    exchange = _exchanges(own, heard + controller.estimator.message_path, apart)
    return np.asarray(_rule(controller)(exchange)[:, PREY], np.float64).reshape(STEPS, STEPS)


def _rule(controller: LayeredController) -> Callable[[Array], Array]:
    """Return the weighting of a controller as a function of exchanges; ConfigError without one."""
    scenario, weighting = Scenario(), controller.weighting
    if hasattr(weighting, "layer"):
        layer = weighting.layer(scenario) or controller.estimator.layer(scenario).own_weighting
        if layer is not None:
            return RowWeighting(layer)
    if not callable(weighting):
        raise ConfigError(
            f"controller '{controller.name}': its weight depends on more than paths, which"
            " 'weights' cannot show"
        )
    rule: Callable[[Array], Array] = weighting
    return rule


def _exchanges(own: Float64[Array, " rows"], heard: Float64[Array, " rows"], apart: float) -> Array:
    """Return synthetic exchanges about the prey, one for each pair of paths [m]."""
    exchange = Exchange.array((len(own),)).view(np.recarray)
    exchange.is_valid = exchange.own_known = exchange.heard_known = 1.0
    exchange.goal = np.eye(3)[PREY]
    exchange.own_p, exchange.heard_p = (np.stack([p / 4, p], axis=1) for p in (own, heard))
    exchange.disagreement, exchange.range, exchange.n_averaged = apart, RANGE, MESSAGES
    exchange.own_distance = exchange.heard_distance = AWAY
    return exchange
