"""A model card for each bundled policy, in the form of the Hugging Face Hub: PYTHON FILE FOLDER.

They are pages of the site too, without the head that the Hub reads.
"""

import sys
import textwrap
from pathlib import Path

import yaml
from card_tables import table

import training.controllers  # noqa: F401 enters the learned controllers
from baselines.controller import LayeredController
from baselines.evaluation.scores import Score, read_scores
from swarm_forage_env.registry import CONTROLLERS
from training.policy_file import BUNDLED, Card, load_policy

NAMES = sorted(file.stem for file in BUNDLED.glob("*.safetensors"))

SEEN = {
    "weighting": "what a robot and its partner believe of an area, and how they met",
    "motion": "the robot's own sensors, the messages of a tick, and what it believes",
}
"""What a policy of each layer observes, in words."""


def pages() -> dict[str, str]:
    """The text of each card by its place in the documentation."""
    return {f"policies/{name}.md": body(name) for name in NAMES}


def card(name: str) -> str:
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
        for each in scores(name)
    ]
    head = {
        "license": "mit",
        "library_name": "swarm-forage",
        "tags": ["reinforcement-learning", "multi-agent", "swarm-robotics", "e-puck", "pettingzoo"],
        "model-index": [{"name": name, "results": results}],
    }
    return f"---\n{yaml.safe_dump(head, sort_keys=False)}---\n\n{body(name)}"


def controllers(name: str) -> list[str]:
    """The controllers in the box that run a policy."""
    found = []
    for each in CONTROLLERS.loaded():
        if isinstance(each, LayeredController):
            parts = {value for key, value in each.parameters.items() if key.endswith(".policy")}
            found += [each.name] if name in parts else []
    return found


def scores(name: str) -> list[Score]:
    """What these controllers score, by scenario, where that is kept."""
    own = controllers(name)
    return [score for (_, controller), score in read_scores().items() if controller in own]


def body(name: str) -> str:
    """The text of a card."""
    known: Card = load_policy(name).card
    (layer, own), *_ = known.layers.items()
    runs = controllers(name)
    lines = textwrap.wrap(
        known.command, 80, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
    told = "```sh\n" + " \\\n".join(lines) + "\n```"
    interval = "{0.mean:.0f} ({0.low:.0f} to {0.high:.0f})"
    held = [[f"`{where}`", interval.format(each)] for where, each in known.score.items()]
    kept = [[f"`{s.controller}`", f"`{s.scenario}`", _mean(s)] for s in scores(name)]
    facts = [
        ["replaces", f"the {layer} of a hand-written controller"],
        ["observes", f"{SEEN[layer]}: {len(own.observes)} numbers"],
        ["gives", ", ".join(f"`{each.name}` [{each.unit}]" for each in own.gives)],
        ["network", f"`{own.network}`" + "".join(f", {k} {v}" for k, v in own.sizes.items())],
        ["trained by", f"`{known.algorithm}`, seed {known.seed}, beside `{known.controller}`"],
        ["trained in", ", ".join(f"`{each}`" for each in known.scenarios)],
        ["versions", ", ".join(f"{k} {v}" for k, v in known.versions.items())],
        ["SHA-256", f"`{known.sha256}`"],
    ]
    return "\n".join((
        f"# {name}\n",
        f"A policy that takes the place of one layer, the {layer}, of robots that forage. The"
        f" controller{'s' if len(runs) > 1 else ''} {', '.join(f'`{each}`' for each in runs)}"
        f" run{'' if len(runs) > 1 else 's'} it.\n",
        table(("", ""), facts) + "\n",
        "## Run it\n",
        f"```sh\nswarm-forage evaluate es1 ssgikf {' '.join(runs)}\n```\n",
        "## Scores\n",
        "Round trips, nest to prey to nest, of the swarm; means and 95 % bootstrap intervals.\n",
        table(("controller", "scenario", "round trips"), kept) + "\n",
        "On the held-back seeds of its training, by which it was chosen:\n",
        table(("scenario", "round trips"), held) + "\n",
        "## Train it again\n",
        f"{told}\n",
        "## Limits\n",
        "It was trained and tested in simulation alone. What becomes of it with other robots,"
        ' noise, areas and obstacles, and where it falls below the hand-written controller, stands'
        ' under "In other worlds" in the documentation.\n',
    ))  # fmt: skip


def _mean(score: Score) -> str:
    return f"{score.mean:.0f} ({score.low:.0f} to {score.high:.0f}), {score.episodes} episodes"


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name in NAMES:
        (folder / f"{name}.md").write_text(card(name), encoding="utf-8")
