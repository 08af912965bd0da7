"""Make the runs that are missing, in processes, with a bar; score what the cards name."""

import pkgutil
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from baselines.evaluation.backends import Backend
from baselines.evaluation.console import progress_bar, say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from baselines.evaluation.runner import Plan, run_with_progress
from baselines.evaluation.statistics import mean_interval
from baselines.evaluation.tables import scores
from baselines.papers.reproduction import format_duration
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.extras import remedy
from swarm_forage_env.task import task_of
from training.experiment import TEST_SEEDS
from training.ladder.play import Watch, play, random_actions
from training.ladder.rungs import RANDOM, Algorithm, Rung, Score, write_scores
from training.ladder.runs import Job, Run, add_run, find, read_runs, versions

TRAINERS = {
    "sb3": "training.ladder.trainers:by_sb3",
    "cleanrl": "training.ladder.cleanrl_trainer:train",
    "benchmarl": "training.ladder.benchmarl_trainer:train",
    "own": "training.ladder.trainers:by_own_ppo",
    "offline": "training.ladder.trainers:by_transitions",
}
"""What trains by each library: imported where it is used."""

Train = Callable[[Rung, Algorithm, int, Watch], None]
"""Trains from scratch by a seed; the watch evaluates the policy meanwhile, under keywords that the
trainer may change."""


def trainer_of(algorithm: Algorithm) -> Train:
    """What trains it; ModuleNotFoundError, by whose name the command tells what to install."""
    train: Train = pkgutil.resolve_name(TRAINERS[algorithm.trainer])
    return train


def installed(algorithms: Sequence[Algorithm]) -> list[Algorithm]:
    """Those whose library is there; a line says which are left out, and what would install it."""
    there = []
    for algorithm in algorithms:
        try:
            trainer_of(algorithm)
        except (ModuleNotFoundError, ConfigError) as error:
            install = remedy(error.name) if isinstance(error, ModuleNotFoundError) else None
            say(f"{algorithm.name} is left out: {error}{f'; {install}' if install else ''}")
        else:
            there.append(algorithm)
    return there


def jobs_of(
    rungs: Sequence[Rung], algorithms: Sequence[Algorithm], seeds: int, budget: int | None
) -> list[Job]:
    """The easiest rung first, and of it a seed of every algorithm before the next one.

    Of algorithms that are for some rungs only those; ConfigError if that leaves none.
    """
    jobs = [
        Job(rung, algorithm, seed, budget)
        for rung in rungs
        for seed in range(seeds)
        for algorithm in algorithms
        if not algorithm.rungs or rung.name in algorithm.rungs
    ]
    if seeds and not jobs:
        known = ", ".join(f"{each.name} is for {', '.join(each.rungs)}" for each in algorithms)
        raise ConfigError(f"--algorithm: {known}; name such a rung, or another algorithm")
    return jobs


def run_jobs(jobs: Sequence[Job], out: Path, backend: Backend) -> None:
    """Make the runs that a file lacks, and add them to it: a line for each tells the time left.

    There is a bar too if stderr is a terminal.
    """
    runs = read_runs(out)
    todo = [job for job in jobs if find(job, runs) is None]
    say(f"{len(jobs) - len(todo)} of {len(jobs)} runs found in {out}, {len(todo)} to make")
    for algorithm in {job.algorithm.name: job.algorithm for job in todo}.values():
        trainer_of(algorithm)  # tells early what is missing
    begin, done, in_all = time.monotonic(), 0, sum(job.robot_steps for job in todo)
    with progress_bar("runs") as progress, closing(backend.run(make, todo)) as finished:
        bar = progress.add_task("", total=len(todo))
        for run in finished:
            add_run(run, out)
            progress.advance(bar)
            done += run.robot_steps
            left = (time.monotonic() - begin) * (in_all - done) / done
            say(
                f"{run.rung}, {run.algorithm}, seed {run.seed}: {run.score:.1f} after"
                f" {run.robot_steps / 1e6:g} M robot-steps in {run.train_s:.0f} s;"
                f" about {format_duration(left)} left"
            )
    say(f"done in {time.monotonic() - begin:.0f} s")


def make(job: Job) -> Run:
    """Train, and score the best policy in the test episodes."""
    watch = Watch(job.rung.test_keywords, job.robot_steps, job.rung.card.curve_episodes)
    trainer_of(job.algorithm)(job.rung, job.algorithm, job.seed, watch)
    assert watch.best is not None
    seeds = TEST_SEEDS[: job.rung.card.episodes]
    return Run(
        rung=job.rung.name,
        algorithm=job.algorithm.name,
        seed=job.seed,
        key=job.key,
        config=job.config,
        robot_steps=job.robot_steps,
        train_s=watch.curve[-1]["wall_s"],
        curve=watch.curve,
        scores=play(watch.keywords, watch.best, seeds),
        scores_by_chance=play(watch.keywords, watch.best, seeds, by_chance=True),
        versions=versions(),
    )


def score_references(rung: Rung, out: Path, backend: Backend) -> dict[str, Score]:
    """Score what a rung's card names, and write it into the rung's file.

    Episodes are kept in a dataset: a command that was stopped goes on from there.
    """
    seeds, keywords = TEST_SEEDS[: rung.card.episodes], rung.test_keywords
    say(f"{rung.name}: random actions, {len(seeds)} episodes")
    results = {RANDOM: _score(play(keywords, random_actions(keywords), seeds))}
    scenario, dataset = rung.test_scenario, Dataset(out)
    physics = task_of(scenario).physics
    dataset.open()
    configurations = [
        ExperimentConfig(name, scenario, find_layered_controller(name), physics)
        for name in rung.references
    ]
    plan = Plan(configurations, seeds, dataset)
    run_with_progress(plan, backend)
    for name, episodes in zip(rung.references, plan.by_configuration(), strict=True):
        results[name] = _score(scores(episodes))
    write_scores(rung, results)
    return results


def _score(values: Sequence[float]) -> Score:
    estimate = mean_interval(values)
    assert estimate is not None
    low, high = estimate.interval or (None, None)
    return Score(mean=estimate.value, low=low, high=high, episodes=estimate.n)
