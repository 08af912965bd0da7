"""Training of the missing runs in parallel processes, and scoring of the cards' references."""

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
"""Training function of each library, imported when it is used."""

Train = Callable[[Rung, Algorithm, int, Watch], None]
"""Training function: it trains from scratch with a seed. The watch evaluates the policy meanwhile,
under keywords that the function may change."""


def trainer_of(algorithm: Algorithm) -> Train:
    """Import the training function of an algorithm. ModuleNotFoundError names a missing package."""
    train: Train = pkgutil.resolve_name(TRAINERS[algorithm.trainer])
    return train


def installed(algorithms: Sequence[Algorithm]) -> list[Algorithm]:
    """Return the algorithms whose library is installed; print a line for each of the others."""
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
    """Return jobs in the order of rungs, then of seeds, then of algorithms.

    Algorithms that are limited to some rungs have no jobs on others. ConfigError if none is left.
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
    """Run the jobs that a file lacks, and add each run to it; a line per run reports the time left.

    A progress bar is drawn if stderr is a terminal.
    """
    runs = read_runs(out)
    todo = [job for job in jobs if find(job, runs) is None]
    say(f"{len(jobs) - len(todo)} of {len(jobs)} runs found in {out}, {len(todo)} to make")
    for algorithm in {job.algorithm.name: job.algorithm for job in todo}.values():
        trainer_of(algorithm)  # fails early if a package is missing
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
    """Train an algorithm on a rung, and score its best policy in the test episodes."""
    watch = Watch(job.rung.test_keywords, job.robot_steps, job.rung.card.curve_episodes)
    trainer_of(job.algorithm)(job.rung, job.algorithm, job.seed, watch)
    assert watch.best is not None
    seeds = TEST_SEEDS[: job.rung.card.episodes]
    kinematic = {**watch.keywords, "physics": "kinematic"}
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
        scores_by_chance=play(watch.keywords, watch.best, seeds, stochastic=True),
        versions=versions(),
        scores_kinematic=play(kinematic, watch.best, seeds),
        scores_kinematic_by_chance=play(kinematic, watch.best, seeds, stochastic=True),
    )


def score_references(rung: Rung, out: Path, backend: Backend) -> dict[str, Score]:
    """Score random actions and the references of a rung, and write the scores to the rung's file.

    Episodes are stored in a dataset, from which a stopped command resumes.
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
