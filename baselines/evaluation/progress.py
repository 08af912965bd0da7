"""Progress of long runs, on stderr."""

import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from baselines.evaluation.backends import Backend
from baselines.evaluation.console import progress_bar, say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.episodes_done import EpisodesDone, shown
from baselines.evaluation.runner import Plan

if TYPE_CHECKING:
    from rich.progress import Progress

NAMED = 20
"""Files that a message names, at most."""


def run_with_progress(plan: Plan, backend: Backend) -> None:
    """Run the missing episodes: a line before and after, a bar if stderr is a terminal."""
    begin = time.monotonic()
    total = len(plan.configurations) * len(plan.seeds)
    scenarios = ", ".join(dict.fromkeys(each.scenario.name for each in plan.configurations))
    say(
        f"{scenarios}: {total - plan.n_todo} of {total} episodes"
        f" found in {plan.dataset.name}, {plan.n_todo} to run"
    )
    with progress_bar("episodes") as progress:
        if progress.disable:
            deque(plan.run(backend), maxlen=0)
        else:
            _run_under_bar(plan, progress, backend)
    say(f"done in {time.monotonic() - begin:.0f} s")


def _run_under_bar(plan: Plan, progress: "Progress", backend: Backend) -> None:
    """Run the missing episodes under a bar that says what is compiled.

    It moves within episodes where the workers share the files of this machine.
    """
    bar = progress.add_task("", total=plan.n_todo)

    def tell(what: str) -> None:
        progress.update(bar, description=what)

    if not (backend.shares_files and plan.dataset.shares_files):
        for n_episodes in plan.run(backend, tell):
            progress.advance(bar, n_episodes)
        return
    with TemporaryDirectory(prefix="swarm-forage-") as folder:
        done = EpisodesDone(Path(folder) / "episodes")
        with shown(done, progress, bar):
            deque(plan.run(backend, tell, done), maxlen=0)


def check_kept(plan: Plan) -> None:
    """Raise OSError, which names the files, unless every episode of the plan is kept."""
    check_files(plan.dataset, plan.files)
    if plan.trajectories:
        beside = plan.trajectories.dataset
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
