"""Open numbers: their posterior given the published ones, and claims that exclude each other.

python -m baselines.papers.open_numbers --sets 10000    # search, then write the page
python -m baselines.papers.open_numbers --arenas 300    # measure the best ones in all arenas
python -m baselines.papers.open_numbers --best 3        # check the best of these
"""

import json
from collections.abc import Mapping, Sequence
from importlib.resources import files
from itertools import combinations
from pathlib import Path
from string import Template
from typing import Annotated, Any

import numpy as np
import typer
from matplotlib.figure import Figure
from typer import Option

from baselines.cli import run, stoppable
from baselines.evaluation.common_options import FileOption
from baselines.evaluation.console import say
from baselines.evaluation.figure_page import (
    Caption,
    finish_figure,
    label_panel,
    panel_grid,
    save_figure,
)
from baselines.evaluation.plot_style import FAINT, INK
from baselines.evaluation.tables import markdown
from baselines.papers.claim_types import shown
from baselines.papers.open_claims import (
    ARENAS,
    CHECKED,
    Sets,
    check,
    claims_of,
    measure_in_all_arenas,
    sets_in,
)
from baselines.papers.open_prior import PRIOR, Value, place_of, today, values_of
from baselines.papers.open_search import FIRST, PUBLISHED, search
from baselines.papers.report import left_open
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.atomic_write import write_atomically

COMMAND = "python -m baselines.papers.open_numbers"
FILE = Path("docs/papers/open_numbers.parquet")
EPISODES = Path("runs/open_numbers/episodes")
LEFT_OPEN = "open_prior", "open_search", "open_search:fit_emulator", "open_claims"
GIVEN = "es1", "es1 and es2"  # arenas that a posterior is conditioned on
GOAL = 10_000  # number of sets that the search aims at
SHOWN = 3  # checked sets in the table of claims: today's, and those in which most claims hold


def n_held(each: Mapping[str, Any]) -> int:
    """Return how many claims hold in a checked set."""
    return sum(each["holds"].values())


def cell(value: Value) -> str:
    """Format a value for a table."""
    return shown(value) if isinstance(value, float) else str(value).lower()


def posterior_of(sets: Sets, name: str, weights: Float64[Array, " draws"]) -> str:
    """Return median and 95 % interval of the posterior of a number, or the shares of a rule."""
    places = sets.prior[:, list(PRIOR).index(name)]
    if isinstance(PRIOR[name], tuple):
        first = weights[places < 0.5].sum() / weights.sum()
        shares = zip(PRIOR[name], (first, 1.0 - first), strict=True)
        return ", ".join(f"{cell(option)} {share:.0%}" for option, share in shares)
    order = np.argsort(places)
    at = np.searchsorted(np.cumsum(weights[order]) / weights.sum(), (0.5, 0.025, 0.975))
    ends = [values_of(np.full(len(PRIOR), each))[name] for each in places[order][at]]
    return "{} ({} to {})".format(*map(cell, ends))


def numbers_table(sets: Sets) -> str:
    """Return prior, today's value, posteriors and the value in the best set of each number."""
    best = sets.best(*CHECKED)[0]
    values = values_of(sets.draws[best])
    rows = []
    for name, prior in PRIOR.items():
        ends = prior if isinstance(prior, tuple) else map(float, prior.support())
        posteriors = [posterior_of(sets, name, weights) for weights in sets.posterior]
        said = " to ".join(map(cell, ends)), cell(today()[name]), *posteriors, cell(values[name])
        rows.append((f"`{name}`", *said))
    heads = "number", "prior", "today", *GIVEN, f"set {best}"
    return markdown(heads, rows)


def published_table(sets: Sets) -> str:
    """Return the values of each published number over the sets within the tolerances of es1."""
    rows = []
    for arena in ARENAS:
        for k, (name, (low, high, *_)) in enumerate(PUBLISHED[arena].items()):
            ours = sets.numbers[arena][sets.near, k]
            low_end, middle, high_end = map(float, np.percentile(ours, (2.5, 50.0, 97.5)))
            near = np.mean((0.9 * low <= ours) & (ours <= 1.1 * high))
            published = cell(low) if low == high else f"{cell(low)} to {cell(high)}"
            own = cell(float(sets.numbers[arena][0, k]))
            ends = f"{cell(middle)} ({cell(low_end)} to {cell(high_end)})"
            rows.append((f"{arena}: {name}", published, own, ends, f"{near:.0%}"))
    return markdown(("number", "published", "today", "these sets", "within 10 %"), rows)


def claims_table(sets: Sets, checked: Sequence[Mapping[str, Any]]) -> str:
    """Return in how many sets of the search, and in which checked sets, each claim holds."""
    words, rows = {True: "yes", False: "no", None: "-"}, []
    checked = [*checked[:1], *sorted(checked[1:], key=n_held, reverse=True)[: SHOWN - 1]]
    for text in (each.text for each in claims_of(*CHECKED)):
        judged = [each[text] for each in sets.held if text in each]
        share = f"{sum(judged)} of {len(judged)}" if judged else "-"
        rows.append((text, share, *(words[each["holds"].get(text)] for each in checked)))
    sums = [f"**{n_held(each)} of {len(each['holds'])}**" for each in checked]
    heads = [f"{each['name']}, `{each['physics']}`" for each in checked]
    return markdown(("claim", "sets of the search", *heads), [*rows, ("**all**", "", *sums)])


def pairs_table(sets: Sets) -> str:
    """Return the pairs of claims that hold together in at most half as many sets as by chance."""
    rows = []
    for one, other in combinations([each.text for each in claims_of(*CHECKED)], 2):
        both = np.array([(each[one], each[other]) for each in sets.held if {one, other} <= {*each}])
        alone, together = both.sum(axis=0), int(both.all(axis=-1).sum())
        chance = alone.prod() / max(len(both), 1)
        if chance >= 3.0 and together <= 0.5 * chance:
            counts = *map(str, alone), str(len(both)), f"{together}", f"{chance:.1f}"
            rows.append((together / chance, one, other, *counts))
    heads = "claim", "and", "the first in", "the second in", "of", "both in", "both by chance"
    return markdown(heads, [row[1:] for row in sorted(rows)])


def posterior_figure(sets: Sets) -> Figure:
    """Plot the posterior of each number over its prior, which is 1 everywhere."""
    figure, panels = panel_grid(len(PRIOR), 1.6, 1.15)
    for column, (axes, name) in enumerate(zip(panels, PRIOR, strict=True)):
        n_bins = 2 if isinstance(PRIOR[name], tuple) else 10
        for label, colour, weights in zip(GIVEN, ("C0", "C1"), sets.posterior, strict=True):
            shares = n_bins * weights / weights.sum()
            height, edges = np.histogram(sets.prior[:, column], n_bins, (0.0, 1.0), weights=shares)
            axes.stairs(height, edges, label=label, color=colour, linewidth=1.4)
        axes.axhline(1.0, color=FAINT, linewidth=0.7)
        axes.axvline(place_of(today())[column], color=INK, linewidth=0.9, linestyle=":")
        ends = [values_of(np.full(len(PRIOR), at))[name] for at in (0.0, 1.0 - 1e-9)]
        label_panel(axes, name.replace(".", "\n"), ("", ""))
        axes.set_xticks((0.25, 0.75) if n_bins == 2 else (0.0, 1.0), list(map(cell, ends)))
        axes.set_yticks(())
    words = "Posterior of each open number over its prior; dotted: today's value."
    caption = Caption(words, f"{len(sets.draws)} sets", COMMAND)
    return finish_figure(figure, panels, caption, GIVEN)


def facts(sets: Sets, checked: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Return the values to insert into the text of the page."""
    near, measured = sets.near, sets.total(*ARENAS) >= 0
    best, total = sets.best(*CHECKED), sets.total(*CHECKED)
    others = total[[k for k in best if k]]
    ever = {text for each in sets.held for text, holds in each.items() if holds}
    never = [each.text for each in claims_of(*CHECKED) if each.text not in ever]

    def scores_of(k: int) -> str:
        scores = (f"{of[k]} of {len(claims_of(a))} of {a}" for a, of in sets.scores.items())
        return f"{total[k]}: {', '.join(scores)}"

    return {
        "n_numbers": str(len(PRIOR)), "goal": f"{GOAL:,}", "n": f"{len(sets.draws):,}",
        "near": str(near.sum()), "excludes": f"{3.0 / near.sum():.1%}",
        "whole": str(measured.sum()), "share": f"{sets.posterior[0].mean():.2%}",
        "even": f"{near[1:FIRST].sum()} of {FIRST - 1}",
        "within": str((sets.far["es2"] <= 1.0).sum()),
        "both": f"{sets.posterior[1].sum() / sets.posterior[0].sum():.2%}",
        "least": f"{sets.far['es2'][near].min():.1f}",
        "n_arenas": str(len(others)), "middle": f"{np.median(others):g}",
        "more": str((others > total[0]).sum()), "fewer": str((others < total[0]).sum()),
        "n_front": str(len(sets.front(*CHECKED))), "best": f"set {best[0]}",
        "most": scores_of(best[0]), "ever": str(len(ever)),
        "never": f", but never {'; '.join(never)}" if never else "",
        **{f"{arena}_betas": ", ".join(f"{beta} in {n}" for beta, n in sorted(of.items()))
           for arena, of in sets.best_betas.items()},
        "today": scores_of(0),
        "n_checked": str(len(checked) - 1), "n_claims": str(len(claims_of(*CHECKED))),
        "checked": ", ".join(f"{each['name']} {n_held(each)}" for each in checked),
        "worlds": ", ".join(f"{n} of {arena}" for arena, n in CHECKED.items()),
    }  # fmt: skip


def write_page(file: Path) -> None:
    """Write the page and its figure next to the file of the sets."""
    sets, checks = sets_in(file), file.with_suffix(".json")
    checked = json.loads(checks.read_text()) if checks.exists() else []
    save_figure(posterior_figure(sets), file.parent / "figures" / "open_numbers.png")
    text = (files("baselines.papers") / "pages" / "open_numbers.md").read_text("utf-8")
    chosen = "\n\n".join(left_open(f"baselines.papers.{each}") for each in LEFT_OPEN)
    page = Template(text).substitute(
        facts(sets, checked), command=COMMAND, posterior=numbers_table(sets), left_open=chosen,
        published=published_table(sets), claims=claims_table(sets, checked),
        pairs=pairs_table(sets),
    )  # fmt: skip
    write_atomically(file.with_suffix(".md"), page.encode())


def check_best(file: Path, best: int, physics: str) -> None:
    """Check today's set and the best ones in other worlds of all arenas, and save the results."""
    sets, checks = sets_in(file), file.with_suffix(".json")
    numbers = [k for k in sets.best(*CHECKED) if k][:best]
    chosen = {"today": None} | {f"set {k}": values_of(sets.draws[k]) for k in numbers}
    checked: list[dict[str, Any]] = [
        {"name": name, "physics": physics, "values": values, "holds": {}}
        for name, values in chosen.items()
    ]
    for arena in CHECKED:
        for each in checked:
            each["holds"] |= check(each["values"], arena, physics, EPISODES)
        write_atomically(checks, (json.dumps(checked, indent=1) + "\n").encode())
        say(f"{arena}: {len(checked)} sets checked")


app = typer.Typer(name=COMMAND, add_completion=False)


@app.command()
@stoppable()
def command(
    sets: Annotated[int, Option(min=0, help="Number of sets in all, stored ones included.")] = 0,
    arenas: Annotated[int, Option(min=0, help="Best of es1 and es2 to measure in all arenas.")] = 0,
    best: Annotated[int, Option(min=0, help="Best in all arenas to check in other worlds.")] = 0,
    physics: Annotated[str, Option(help="Engine of the checks.")] = "rigid",
    seed: Annotated[int, Option(min=0, help="Seed of the search.")] = 0,
    file: Annotated[Path, FileOption(help="File of the sets; the page goes beside it.")] = FILE,
) -> None:
    """Search the numbers that the papers leave open, check the best sets, and write the page.

    A stopped search resumes from the saved sets.
    """
    search(file, sets, seed)
    if arenas:
        measure_in_all_arenas(file, arenas)
    if best:
        check_best(file, best, physics)
    write_page(file)


if __name__ == "__main__":
    raise SystemExit(run(commands=app))
