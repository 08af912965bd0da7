"""Tables of the command `list` for a terminal, whose first column is never broken."""

from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from baselines.controller import LayeredController
from baselines.evaluation.listing import find, grouped_parameters
from baselines.evaluation.scores import (
    EPISODES,
    Score,
    score_of_controller,
    score_of_scenario,
)
from swarm_forage_env.parameters import leaves
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import CONTROLLERS, POLICIES, REFERENCES, SCENARIOS, Registry

EXAMPLES = ("radio.max_range", "task.tolerance")
"""Numbers that an example of a change is made with, where a scenario has them."""

SCENARIO_SCORES = (
    "score: round trips under ssgikf, share gathered under gather, goals of a robot\n"
    f"under boids-adaptive; mean of {EPISODES} episodes"
)

CONTROLLER_SCORES = f"score: round trips on es1, mean of {EPISODES} episodes"


def overview_tables() -> Group:
    """Tables of all names."""
    return Group(
        _scenarios(), Text(SCENARIO_SCORES), Text(),
        _controllers("controller", CONTROLLERS), Text(CONTROLLER_SCORES), Text(),
        Text("References, which know the truth: to compare with, not to use"),
        _controllers("reference", REFERENCES), Text(), _engines(), Text(), _policies(), Text(),
        Text("Every number of one of them: swarm-forage list es1, swarm-forage list ssgiff"),
    )  # fmt: skip


def detail_table(name: str) -> Group:
    """Tables of every parameter of one scenario or controller."""
    found = find(name)
    parts: list[Any] = []
    for group, about, parameters in grouped_parameters(found):
        heading = Text(group, style="bold").append(f"  {about}", style="not bold")
        table = _table("parameter", "value", "unit", "origin", "meaning")
        for each in parameters:
            cells = each.name, _shown(each.value), each.unit, each.origin, each.meaning
            table.add_row(*map(Text, cells))
        parts += [heading, table, Text()]
    return Group(*parts, Text(f"Change one in evaluate with {_way(name, found)}"))


def _scenarios() -> Table:
    table = _table("scenario", "robots", "time [s]", "score", "what it is")
    for column in table.columns[1:4]:
        column.justify = "right"
    for name in SCENARIOS:
        task = SCENARIOS[name].task
        score, about = _score(score_of_scenario(name)), SCENARIOS.about(name)
        table.add_row(name, str(task.n_robots), f"{task.duration:g}", score, about)
    return table


def _controllers(kind: str, registry: Registry[Any]) -> Table:
    table = _table(kind, "score", "what it is")
    table.columns[1].justify = "right"
    for name in registry:
        table.add_row(name, _score(score_of_controller(name)), registry.about(name))
    return table


def _policies() -> Table:
    table = _table("policy", "what it is")
    for name in POLICIES:
        table.add_row(f"{name}:FILE", POLICIES.about(name))
    return table


def _engines() -> Table:
    table = _table("engine", "what it is")
    for name in ENGINES:
        table.add_row(name, ENGINES.about(name))
    return table


def _table(*headings: str) -> Table:
    """A table of words, the first of which is a name."""
    table = Table(box=None, padding=(0, 2, 0, 0))
    for number, heading in enumerate(headings):
        table.add_column(Text(heading), overflow="fold", no_wrap=number == 0)
    return table


def _score(score: Score | None) -> str:
    return "" if score is None else f"{score.mean:.{0 if score.mean >= 10.0 else 1}f}"


def _way(name: str, found: Any) -> str:  # noqa: ANN401 as `find` gives
    """How a number of what was found is changed on the command line."""
    bare = name.partition(":")[0]
    if not isinstance(found, LayeredController):
        return f"--set {_example(found)}"
    return f"{bare}:FILE,name=value" if bare in POLICIES else f"{bare}:name=value"


def _example(scenario: Any) -> str:  # noqa: ANN401 of any task
    """How a number of the scenario is changed."""
    numbers = leaves(scenario.model_dump(exclude={"name"}))
    name = next(each for each in (*EXAMPLES, *numbers) if each in numbers)
    return f"{name}={_shown(numbers[name])}"


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
