"""The two kinds of task, foraging and waypoints, with their episodes and metrics."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from baselines.evaluation.episode import Episode, run_episodes
from baselines.evaluation.waypoint_episode import WaypointEpisode, run_waypoint_episodes
from swarm_forage_env.waypoints_scenario import AnyScenario, WaypointsScenario

AnyEpisode = Episode | WaypointEpisode


@dataclass(frozen=True)
class Kind:
    """A kind of task: its episode type, its runner, its score and its metrics."""

    episode: type[Any]
    run: Callable[..., Sequence[Any]]
    """From scenario, recipe, seeds and engine to episodes."""

    score: str
    """Field by which controllers are compared."""

    score_words: str
    """The same for a reader."""

    columns: Mapping[str, tuple[str, float]]
    """Metrics in the order of the table, with their headings and the factor to their units."""

    def axis(self, metric: str) -> str:
        """The heading of a metric in one line, as an axis label."""
        return self.columns[metric][0].replace("-\n", "").replace("\n", " ")


FORAGING = Kind(
    Episode,
    run_episodes,
    "round_trips",
    "Round trips",
    {
        "round_trips": ("round\ntrips", 1.0),
        "recruitment_time_s": ("recruit-\nment [s]", 1.0),
        "on_path_share": ("on path\n[%]", 100.0),
        "lost_events": ("lost\nevents", 1.0),
        "messages": ("messages\n[1000]", 0.001),
        "localisation_error_m": ("location\nerror [cm]", 100.0),
    },
)

WAYPOINTS = Kind(
    WaypointEpisode,
    run_waypoint_episodes,
    "goals_per_robot",
    "Goals per robot",
    {
        "goals_per_robot": ("goals a\nrobot", 1.0),
        "false_goals_per_robot": ("false\ngoals", 1.0),
        "success_rate": ("success\n[%]", 100.0),
        "position_error_m": ("position\nerror [cm]", 100.0),
        "covariance_norm": ("covari-\nance", 1.0),
    },
)


def kind_of(thing: AnyScenario | AnyEpisode) -> Kind:
    """The kind of task of a scenario or an episode."""
    return WAYPOINTS if isinstance(thing, WaypointsScenario | WaypointEpisode) else FORAGING
