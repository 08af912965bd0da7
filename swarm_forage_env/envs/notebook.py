"""HTML of an environment for notebooks: a picture of the current state, and a table."""

import html
from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from swarm_forage_env.interface import Controller
from swarm_forage_env.rendering.viewer import Viewer
from swarm_forage_env.task import stage_of

if TYPE_CHECKING:
    from swarm_forage_env.envs.array_env import ArrayEnv


def title_of(env: "ArrayEnv") -> str:
    """Return the title of a picture: the controllers, and the layer of the policy."""
    controller, learn = env.base_controller, env.config.learn
    if learn == "everything":
        return "policy"
    several = controller.values() if isinstance(controller, Mapping) else controller
    each = several if isinstance(several, Iterable) and not isinstance(several, str) else [several]
    names = dict.fromkeys(
        one.name if isinstance(one, Controller) else str(one or env.task.controller) for one in each
    )
    return f"{', '.join(names)}, policy for {learn}"


def html_of(env: "ArrayEnv", kind: str) -> str:
    """Return the HTML of an environment: a picture of the first world, and a table."""
    config, world, moved_by = env.config, env.world, title_of(env)
    learners = len(env.learners)
    facts = [
        ("scenario", f"{world.scenario.name} ({env.task.name}), {moved_by}"),
        ("worlds, robots", f"{world.n_worlds} of {world.n_robots}, {learners} of which learn"),
        ("engine", env.loop.physics),
        ("decision", f"every {config.period} ticks of {world.scenario.tick:g} s"),
        ("episode", f"{env.max_cycles} decisions"),
        ("reward", getattr(config.reward, "__name__", str(config.reward))),
        ("action", f"{env.action_space}: {', '.join(env.action_layout.names)}"),
        ("observation", f"{len(env.observation_layout)} numbers"),
    ]
    layout = env.observation_layout._repr_html_()
    details = f"<details><summary>what is observed</summary>{layout}</details>"
    return f"<div><b>{html.escape(kind)}</b>{_picture(env, moved_by)}{_rows(facts)}{details}</div>"


def _picture(env: "ArrayEnv", moved_by: str) -> str:
    """Return a picture of the first world; empty if it cannot be drawn or has not begun."""
    if not env.episodes.has_begun or env.task.scene is None or find_spec("pygame") is None:
        return ""
    frame = Viewer(stage_of(env.world.scenario, moved_by), "rgb_array").draw(env.loop.scene(0))
    return f"<div>{frame._repr_html_()}</div>"  # type: ignore[union-attr]


def _rows(facts: Sequence[tuple[str, str]]) -> str:
    cells = (
        f'<tr><th style="text-align:left">{html.escape(name)}</th>'
        f'<td style="text-align:left">{html.escape(value)}</td></tr>'
        for name, value in facts
    )
    return f"<table>{''.join(cells)}</table>"
