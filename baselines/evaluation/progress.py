"""Progress of long runs, on stderr."""

import time
from collections.abc import Sequence
from pathlib import Path

from baselines.evaluation.backends import Backend
from baselines.evaluation.console import progress_bar, say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.runner import Plan

NAMED = 20
"""Files that a message names, at most."""


def run_with_progress(plan: Plan, backend: Backend) -> None:
    """Run the missing episodes: a line before and after, a bar if stderr is a terminal.

    The bar says what is compiled, and counts the episodes that are kept.
    """
    begin = time.monotonic()
    total = len(plan.configurations) * len(plan.seeds)
    scenarios = ", ".join(dict.fromkeys(each.scenario.name for each in plan.configurations))
    say(
        f"{scenarios}: {total - plan.n_todo} of {total} episodes"
        f" found in {plan.dataset.name}, {plan.n_todo} to run"
    )
    with progress_bar("episodes") as progress:
        bar = progress.add_task("", total=plan.n_todo)

        def tell(what: str) -> None:
            progress.update(bar, description=what)

        for n_episodes in plan.run(backend, tell):
            progress.advance(bar, n_episodes)
    say(f"done in {time.monotonic() - begin:.0f} s")


def check_kept(plan: Plan) -> None:
    """Raise OSError, which names the files, unless every episode of the plan is kept."""
    check_files(plan.dataset, plan.files)
    if plan.trajectories:
        beside = plan.trajectories
        wanted = [beside.place(each, s) for each in plan.configurations for s in plan.seeds]
        check_files(beside, wanted)


def check_files(dataset: Dataset, wanted: Sequence[Path]) -> None:
    """Raise OSError, which names those that are gone, unless a dataset holds all files."""
    missing, folder = dataset.missing(wanted), dataset.folder
    if missing:
        names = ", ".join(str(file.relative_to(folder)) for file in missing[:NAMED])
        more = f" and {len(missing) - NAMED} more" if len(missing) > NAMED else ""
        raise OSError(
            f"{dataset.name}: {len(missing)} of {len(wanted)} episodes are not there any more:"
            f" {names}{more}; the results above count them, and the same command runs them again"
            " where it needs them"
        )
