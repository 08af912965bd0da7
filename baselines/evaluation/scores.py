"""Scores of scenarios and controllers, which `list` shows and `make scores` measures.

A scenario is scored under the default controller of its task, a controller in `es1`. Both use the
default engine and the seeds from 0 on.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import typer

from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.registry import CONTROLLERS, REFERENCES, SCENARIOS
from swarm_forage_env.task import task_of

FILE = Path(__file__).with_name("scores.json")

ARENA = "es1"  # scenario in which controllers are scored

EPISODES = 10


@dataclass(frozen=True)
class Score:
    """Mean score of a controller in a scenario."""

    scenario: str
    controller: str
    mean: float
    low: float | None  # lower end of the 95 % interval; None if all episodes score the same
    high: float | None
    episodes: int


@cache
def read_scores() -> dict[tuple[str, str], Score]:
    """Return the scores in FILE by scenario and controller."""
    scores = [Score(**each) for each in json.loads(FILE.read_text(encoding="utf-8"))]
    return {(each.scenario, each.controller): each for each in scores}


def score_of(name: str) -> Score | None:
    """Return the score of a scenario or of a controller; None if not measured."""
    of = (name, task_of(SCENARIOS[name]).controller) if name in SCENARIOS else (ARENA, name)
    return read_scores().get(of)


def pairs() -> Iterator[tuple[str, str]]:
    """Yield the pairs of scenario and controller that are scored."""
    for registry in (CONTROLLERS, REFERENCES):
        yield from ((ARENA, name) for name in registry if registry[name].supports(SCENARIOS[ARENA]))
    others = (name for name in SCENARIOS if name != ARENA)
    yield from ((name, task_of(SCENARIOS[name]).controller) for name in others)


def measure(scenario: str, controller: str, out: Path, workers: int) -> Score:
    """Run the episodes that are not in the folder yet, and return the score of all."""
    from baselines.evaluation.backends import JoblibBackend
    from baselines.evaluation.evaluate_options import EvaluateOptions
    from baselines.evaluation.runner import run_with_progress
    from baselines.evaluation.statistics import mean_interval
    from baselines.evaluation.tables import scores

    plan = EvaluateOptions(scenario, [controller], EPISODES).plan(out)
    run_with_progress(plan, JoblibBackend(workers))
    mean = mean_interval(scores(plan.results()))
    assert mean is not None
    low, high = (round(end, 2) for end in mean.interval) if mean.interval else (None, None)
    return Score(scenario, controller, round(mean.value, 2), low, high, mean.n)


def main(workers: int = 2, out: Path = Path("runs/scores")) -> None:
    """Measure every score, and write the file that `list` reads."""
    lines: list[str] = []
    for scenario, controller in pairs():
        lines.append(json.dumps(asdict(measure(scenario, controller, out, workers))))
        write_atomically(FILE, "[\n{}\n]\n".format(",\n".join(lines)).encode())


if __name__ == "__main__":
    typer.run(main)
