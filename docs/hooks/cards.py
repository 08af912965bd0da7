"""A card for each environment and each rung of the ladder, written from the code."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import card_tables
import model_cards

from swarm_forage_env import parallel_env
from swarm_forage_env.envs.registration import NAMES
from swarm_forage_env.registry import SCENARIOS
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of
from training.ladder.page import best_shown, shown
from training.ladder.rungs import RANDOM, Rung, read_rungs

TIMES = "\N{MULTIPLICATION SIGN}"

EASIEST_FIRST = ("near", "es1-clean", "es1", "real", "ants2008", "es2", "es3")
ARENAS = "mg1-square", "mg1-hexagon", "mg1-dodecagon", "two-prey", "moving-prey", "two-nests"
WAYPOINTS = "waypoints-05", "waypoints-10", "waypoints-25", "waypoints-50"

MOMENTS = {
    **dict.fromkeys((*EASIEST_FIRST, *ARENAS), 420),
    **{"near": 120, "es2": 1800, "es3": 1800, "moving-prey": 860},
}
"""Scenarios with a playground under build/replays, and a time when the swarm knows its way [s]."""

KINDS = "", "-Joint", "-Tuple"
"""Forms of the environment in Gymnasium: one learner, all in one Box, all in tuples."""

RUNG_HEADS = "", "task", "robots learn", "random", "best hand-written", "oracle"
LAYERS = {
    "weighting": "What a policy sees and gives in the place of the weighting",
    "motion": "What a policy sees and gives in the place of the motion",
    "everything": "What a policy sees and gives that is everything",
}
REWARDS = {
    "foraging": "1 to a robot in the tick in which it completes a round trip, nest to prey to nest;"
    ' `reward="team"` gives the mean to all. `shaping=w` adds the potential.'
    " [Reward](../environment.md#reward)",
    "aggregation": "In each tick the share of the swarm that stands on the spot of the robot, for"
    " each second; 0 beside the spots.",
    "waypoints": "1 to a robot for a goal that it rightly claims to have reached, 0 for a wrong"
    " claim. [Waypoints](../environment.md#waypoints)",
}


def pages() -> dict[str, str]:
    """The text of every card by its place in the documentation."""
    found = {"environments/index.md": _index()}
    for name in _scenarios():
        found[f"environments/{name}.md"] = _scenario_card(name)
    for rung in read_rungs().values():
        found[f"environments/ladder-{rung.name}.md"] = _rung_card(rung)
    return found | model_cards.pages()


def navigation() -> list[object]:
    """Entries of the navigation for all cards."""
    ladder = [{_rung_title(r): f"environments/ladder-{r.name}.md"} for r in read_rungs().values()]
    worlds = [{name: f"environments/{name}.md"} for name in _scenarios()]
    policies = [{name: f"policies/{name}.md"} for name in model_cards.NAMES]
    return [
        "environments/index.md",
        {"Scenarios": worlds},
        {"Tasks of the ladder": ladder},
        {"Bundled policies": policies},
    ]


def _scenarios() -> list[str]:
    return [*EASIEST_FIRST, *(name for name in NAMES if name not in EASIEST_FIRST)]


def _rung_title(rung: Rung) -> str:
    return f"{rung.card.rung} {rung.card.title}"


def _index() -> str:
    """The overview: all scenarios, all rungs."""
    worlds = [
        [f"[`{name}`]({name}.md)", _about(name), *(_size(find_scenario(name)))]
        for name in _scenarios()
    ]
    rungs = [
        [str(r.card.rung), f"[{r.card.title}](ladder-{r.name}.md)", str(r.keywords["learn"]),
         shown(r.card.scores.get(RANDOM)), best_shown(r), shown(r.card.scores.get(r.card.oracle))]
        for r in read_rungs().values()
    ]  # fmt: skip
    return "\n".join((
        "# Environments\n",
        "Each card is written from the code when this site is built. How an environment is made,"
        " with all keywords, stands in [The environment](../environment.md).\n",
        "## Scenarios\n",
        card_tables.table(("name", "what it is", "robots", "arena", "an episode"), worlds),
        "\n## Tasks of the ladder\n",
        "Named tasks of rising difficulty, to learn from scratch. How they are scored, and what"
        " algorithms reach, stands in [The ladder](../ladder.md).\n",
        card_tables.table(RUNG_HEADS, rungs),
        "",
    ))  # fmt: skip


def _about(name: str) -> str:
    """What a scenario is, in a few words, the first one capitalised but if it is a name."""
    about = SCENARIOS.about(name)
    return about if about.split()[0] in SCENARIOS else about[0].upper() + about[1:]


def _size(scenario: Any) -> tuple[str, str, str]:
    """How many robots, how large, how long."""
    seconds = scenario.task.duration
    arena = getattr(scenario, "arena", None)
    size = (
        f"{arena.length:.3g} {TIMES} {arena.width:.3g} m"
        if arena
        else f"{scenario.task.side:g} {TIMES} {scenario.task.side:g} m, no walls"
    )
    return str(scenario.task.n_robots), size, f"{seconds:g} s, {scenario.n_ticks:,} ticks"


def _scenario_card(name: str) -> str:
    """The card of a scenario."""
    scenario = find_scenario(name)
    task = task_of(scenario)
    robots, size, lasts = _size(scenario)
    facts = [
        ("robots", robots),
        ("arena", size),
        ("an episode lasts", lasts + "; all robots are truncated together, none terminates"),
        ("PettingZoo", f'`parallel_env("{name}")`, id `swarm_forage/{name}-v2`'),
        ("Gymnasium", ", ".join(f"`SwarmForage/{NAMES[name]}{kind}-v2`" for kind in KINDS)),
        ("batch", f'`ArrayEnv("{name}", n_worlds=64)`'),
        ("reward", REWARDS[task.name]),
        ("default controller", f"`{task.controller}`"),
        ("infos", ", ".join(f"`{key}`" for key in _infos(name))),
    ]  # fmt: skip
    known = card_tables.table(("", ""), [[f"**{a}**", b] for a, b in facts])
    parts = [f"# {name}\n", f"{_about(name)}.\n", f"{known}\n"]
    if name in (*MOMENTS, *WAYPOINTS):
        parts.append(_picture(name))
    if tasks := [r for r in read_rungs().values() if r.test_scenario.name == name]:
        links = ", ".join(f"[{_rung_title(r)}](ladder-{r.name}.md)" for r in tasks)
        parts.append(f"Tasks of the ladder that are scored here: {links}.\n")
        parts += [_scores(next((r for r in tasks if r.card.scores), tasks[0]))]
    for learn, title in LAYERS.items():
        if learn in task.policies:
            parts.append(f"## {title}\n\n{card_tables.policy(name, learn)}")
    parts.append("## Every number\n")
    parts.append(
        f"Change one by keyword or by `--set`; `swarm-forage list {name}` prints them. Its"
        " origin: a paper (published), the authors' code, a measurement (derived), or a choice.\n"
    )
    parts.append(card_tables.numbers(name))
    return "\n".join(parts)


def _picture(name: str) -> str:
    """A playground of ssgikf, or a replay of robots that visit goals."""
    arena = getattr(find_scenario(name), "arena", None)
    is_square = arena is None or arena.width > 0.9 * arena.length
    kind = "replay tall" if is_square else "replay"
    file, does, told = f"{name}.html", "watch", "such a replay"
    controller, made = "boids-adaptive", f"Replay of {name} under boids-adaptive"
    if name in MOMENTS:
        file, does, told = f"{file}#seed=1&t={MOMENTS[name]}", "play", "this page"
        controller, made = "ssgikf", f"{name} under ssgikf: a world to play with"
    return (
        f'<iframe class="{kind}" src="../replays/{file}" loading="lazy" '
        f'title="{made}"></iframe>\n\n'
        f"`swarm-forage {does} {name} {controller} --html {name}.html` makes {told}.\n"
    )


def _rung_card(rung: Rung) -> str:
    """The card of a rung of the ladder."""
    card, learn = rung.card, str(rung.keywords["learn"])
    name = str(rung.keywords["scenario"])
    test = rung.test_scenario
    keywords = ", ".join(
        f"{key}={_literal(value)}" if "." not in key else f'**{{"{key}": {_literal(value)}}}'
        for key, value in sorted(rung.keywords.items(), key=lambda item: "." in item[0])
        if key != "scenario"
    )
    made = textwrap.fill(f'env = parallel_env("{name}", {keywords})', 88, subsequent_indent="    ")
    facts = [
        ("robots learn", f"`{learn}`"),
        ("trained in", f"[`{name}`]({name}.md)"),
        ("scored in", f"[`{test.name}`]({test.name}.md), {test.task.n_robots} robots,"
         f" {test.task.duration:g} s, {card.episodes} episodes, engine"
         f" `{task_of(test).physics}`"),
        ("training", f"{card.robot_steps:,} robot-steps"),
        ("a normalised score of 1", f"`{card.oracle}`"),
    ]  # fmt: skip
    return "\n".join((
        f"# Rung {card.rung}: {card.title}\n",
        f"**What is hard.** {card.hard}\n",
        card_tables.table(("", ""), [[f"**{a}**", b] for a, b in facts]) + "\n",
        "```python\nfrom swarm_forage_env import parallel_env\n\n" + made + "\n```\n",
        "```sh\nswarm-forage benchmark ladder --rung " + rung.name + " --algorithm sb3_ppo\n```\n",
        _scores(rung),
        f"What algorithms make of it that learn from scratch: {_results(rung)}.\n",
        f"## What a policy sees and gives\n\n{card_tables.policy(name, learn)}",
    ))  # fmt: skip


def _results(rung: Rung) -> str:
    """A link to what algorithms score: to the section of the rung, if the page has one yet."""
    ladder = (Path(__file__).parents[1] / "ladder.md").read_text(encoding="utf-8")
    is_there = f"### {rung.name}\n" in ladder
    return f"[the ladder](../ladder.md{f'#{rung.name}' if is_there else ''})"


def _literal(value: object) -> str:
    """A value as code, text in double quotes."""
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _scores(rung: Rung) -> str:
    """A table of what random actions, controllers and oracles score."""
    card = rung.card
    head = f"## Scores\n\n{'Goals of a robot' if rung.name == 'waypoints' else 'Round trips'}"
    head += f" in an episode of `{rung.test_scenario.name}`, mean and 95 % interval.\n\n"
    if not card.scores:
        return f"{head}Not measured yet: `swarm-forage benchmark cards --rung {rung.name}`.\n"
    order = sorted(card.scores, key=lambda name: card.scores[name].mean)
    rows = [
        [_kind(name, rung), f"`{name}`", shown(card.scores[name]),
         f"{rung.normalised(card.scores[name].mean):.2f}", str(card.scores[name].episodes)]
        for name in order
    ]  # fmt: skip
    return head + card_tables.table(("", "name", "score", "normalised", "episodes"), rows) + "\n"


def _kind(name: str, rung: Rung) -> str:
    if name == RANDOM:
        return "random actions"
    if name in rung.card.controllers:
        return "hand-written"
    return "oracle" if name == rung.card.oracle else "learned, bundled"


def _infos(name: str) -> Sequence[str]:
    return tuple(parallel_env(name).array_env.infos)
