"""A card for each environment, rung of the ladder and bundled policy, written from the code.

`python cards.py FOLDER` writes those of the policies with the head that the Hugging Face Hub reads.
"""

import shlex
import sys
import textwrap
from pathlib import Path
from typing import Any

import card_tables
import yaml

import training.controllers  # noqa: F401 enters the learned controllers
from baselines.controller import LayeredController
from baselines.evaluation.scores import Score, read_scores
from swarm_forage_env import parallel_env
from swarm_forage_env.envs.registration import NAMES
from swarm_forage_env.registry import CONTROLLERS, SCENARIOS
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of
from training.ladder.page import best_shown, shown
from training.ladder.rungs import RANDOM, Rung, read_rungs
from training.network_policy import BUNDLED_NETWORKS
from training.policy_card import read_policy_card
from training.policy_file import BUNDLED, TrainingRecord, load_policy

TIMES = "\N{MULTIPLICATION SIGN}"

EASIEST_FIRST = ("near", "es1-clean", "es1", "real", "ants2008", "es2", "es3")
ARENAS = "mg1-square", "mg1-hexagon", "mg1-dodecagon", "two-prey", "moving-prey", "two-nests"
WAYPOINTS = "waypoints-05", "waypoints-10", "waypoints-25", "waypoints-50"

MOMENTS = {
    **dict.fromkeys((*EASIEST_FIRST, *ARENAS), 420),
    **{"near": 120, "es2": 1800, "es3": 1800, "moving-prey": 860},
}
"""Scenarios with a playground under build/replays, and a time when the swarm knows its way [s]."""

REWARDS = {
    "foraging": "1 to a robot in the tick in which it completes a round trip, nest to prey to nest;"
    ' `reward="team"` gives the mean to all. `shaping=w` adds the potential.'
    " [Reward](../environment.md#reward)",
    "aggregation": "In each tick the share of the swarm that stands on the spot of the robot, for"
    " each second; 0 beside the spots.",
    "waypoints": "1 to a robot for a goal that it rightly claims to have reached, 0 for a wrong"
    " claim. [Waypoints](../environment.md#waypoints)",
}

POLICIES = sorted([*BUNDLED_NETWORKS, *(file.stem for file in BUNDLED.glob("*.safetensors"))])

SEEN = {
    "weighting": "what a robot and its partner believe of an area, and how they met",
    "motion": "the robot's own sensors, the messages of a tick, and what it believes",
}
"""What a policy of each layer observes, in words."""


def pages() -> dict[str, str]:
    """The text of every card by its place in the documentation."""
    found = {"environments/index.md": _index()}
    for name in _scenarios():
        found[f"environments/{name}.md"] = _scenario_card(name)
    for rung in read_rungs().values():
        found[f"environments/ladder-{rung.name}.md"] = _rung_card(rung)
    return found | {f"policies/{name}.md": _policy_card(name) for name in POLICIES}


def navigation() -> list[object]:
    """Entries of the navigation for all cards."""
    ladder = [{_rung_title(r): f"environments/ladder-{r.name}.md"} for r in read_rungs().values()]
    worlds = [{name: f"environments/{name}.md"} for name in _scenarios()]
    policies = [{name: f"policies/{name}.md"} for name in POLICIES]
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
    rungs = read_rungs().values()
    return card_tables.rendered("index", worlds=worlds, rungs=rungs, **SHOWN)


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
    task, arena = task_of(scenario), getattr(scenario, "arena", None)
    robots, size, lasts = _size(scenario)
    rungs = [each for each in read_rungs().values() if each.test_scenario.name == name]
    terms = {
        "about": _about(name),
        "robots": robots,
        "size": size,
        "lasts": lasts,
        "gymnasium": NAMES[name],
        "reward": REWARDS[task.name],
        "task": task,
        "infos": list(parallel_env(name).array_env.infos),
        "moment": MOMENTS.get(name),
        "is_replayed": name in WAYPOINTS,
        "is_square": arena is None or arena.width > 0.9 * arena.length,
        "rungs": rungs,
        "rung": next((each for each in rungs if each.card.scores), *rungs[:1] or [None]),
    }
    return card_tables.rendered("scenario", name=name, **terms, **SHOWN)


def _rung_card(rung: Rung) -> str:
    """The card of a rung of the ladder."""
    keywords = ", ".join(
        f"{key}={_literal(value)}" if "." not in key else f'**{{"{key}": {_literal(value)}}}'
        for key, value in sorted(rung.keywords.items(), key=lambda item: "." in item[0])
        if key != "scenario"
    )
    made = f'env = parallel_env("{rung.keywords["scenario"]}", {keywords})'
    ladder = (Path(__file__).parents[1] / "ladder.md").read_text(encoding="utf-8")
    terms = {
        "rung": rung,
        "test": rung.test_scenario,
        "physics": task_of(rung.test_scenario).physics,
        "made": textwrap.fill(made, 88, subsequent_indent="    "),
        "has_results": f"### {rung.name}\n" in ladder,
    }
    return card_tables.rendered("rung", **terms, **SHOWN)


def _literal(value: object) -> str:
    """A value as code, text in double quotes."""
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _kind(name: str, rung: Rung) -> str:
    if name == RANDOM:
        return "random actions"
    if name in rung.card.controllers:
        return "hand-written"
    return "oracle" if name == rung.card.oracle else "learned, bundled"


def model_card(name: str) -> str:
    """The card as the Hub takes it: a head in YAML, and the text."""
    results = [
        {
            "task": {"type": "reinforcement-learning", "name": "multi-robot foraging"},
            "dataset": {
                "type": each.scenario,
                "name": f"{each.scenario}, {each.episodes} episodes",
            },
            "metrics": [{"type": "round_trips", "value": each.mean, "name": "round trips"}],
        }
        for each in _kept_scores(name)
    ]
    head = {
        "license": "mit",
        "library_name": "swarm-forage",
        "tags": ["reinforcement-learning", "multi-agent", "swarm-robotics", "e-puck", "pettingzoo"],
        "model-index": [{"name": name, "results": results}],
    }
    return f"---\n{yaml.safe_dump(head, sort_keys=False)}---\n\n{_policy_card(name)}"


def _controllers(name: str) -> list[str]:
    """The controllers in the box that run a policy."""
    found = []
    for each in CONTROLLERS.loaded():
        if isinstance(each, LayeredController):
            files = (".policy", ".file")
            parts = {value for key, value in each.parameters.items() if key.endswith(files)}
            found += [each.name] if name in parts else []
    return found


def _kept_scores(name: str) -> list[Score]:
    """What these controllers score, by scenario, where that is kept."""
    own = _controllers(name)
    return [score for (_, controller), score in read_scores().items() if controller in own]


def _policy_card(name: str) -> str:
    """The text of a card."""
    known, controller, layer, parts = (_network if name in BUNDLED_NETWORKS else _layer)(name)
    words = (shlex.quote(word).replace(" ", "\0") for word in shlex.split(known.command))
    lines = textwrap.wrap(
        " ".join(words), 80, subsequent_indent="    ", break_long_words=False,
        break_on_hyphens=False,
    )  # fmt: skip
    terms = {
        "layer": layer,
        "parts": parts,
        "seen": SEEN[layer],
        "command": " \\\n".join(lines).replace("\0", " "),
    }
    terms |= {"runs": _controllers(name), "scores": _kept_scores(name), "controller": controller}
    interval = "{0.mean:.0f} ({0.low:.0f} to {0.high:.0f})".format
    return card_tables.rendered("policy", name=name, card=known, interval=interval, **terms)


Described = tuple[TrainingRecord, str, str, dict[str, Any]]
"""Training of a policy, controller beside it, its layer, and what it observes, gives and is."""


def _layer(name: str) -> Described:
    card = load_policy(name).card
    (layer, own), *_ = card.layers.items()
    network = ", ".join([f"`{own.network}`", *(f"{size} {n}" for size, n in own.sizes.items())])
    parts = {"n_observed": len(own.observes), "gives": own.gives, "network": network}
    return card, card.controller, layer, parts


def _network(name: str) -> Described:
    file = BUNDLED_NETWORKS[name]
    card = read_policy_card(file)
    assert card is not None
    assert card.training is not None
    pilot = CONTROLLERS[_controllers(name)[0]].pilot(find_scenario(card.scenario))
    sizes = [int(size) for size in pilot.sizes[1:]]
    network = f"dense, tanh: {f' {TIMES} '.join(map(str, sizes))}"
    parts = {"n_observed": sizes[0], "gives": pilot.form.action.layout, "network": network}
    return card.training, card.controller, card.keywords.learn, parts


SHOWN = {
    "shown": shown,
    "best_shown": best_shown,
    "kind": _kind,
    "table": card_tables.table,
    "policy": card_tables.policy,
    "numbers": card_tables.numbers,
}
"""What the templates call."""


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name in POLICIES:
        (folder / f"{name}.md").write_text(model_card(name), encoding="utf-8")
