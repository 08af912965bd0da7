"""A model card for each bundled policy, in the form of the Hugging Face Hub: PYTHON FILE FOLDER.

They are pages of the site too, without the head that the Hub reads.
"""

import sys
import textwrap
from pathlib import Path

import yaml
from card_tables import rendered

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
    lines = textwrap.wrap(
        known.command, 80, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
    terms = {"layer": layer, "own": own, "seen": SEEN[layer], "command": " \\\n".join(lines)}
    terms |= {"runs": controllers(name), "scores": scores(name)}
    interval = "{0.mean:.0f} ({0.low:.0f} to {0.high:.0f})".format
    return rendered("policy", name=name, card=known, interval=interval, **terms)


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name in NAMES:
        (folder / f"{name}.md").write_text(card(name), encoding="utf-8")
