"""Commands `evaluate`, `plot`, `watch` and `play`; each loads its modules when it runs."""

from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.console import Console
from typer import Argument, Option

from baselines.evaluation.common_options import (
    AddressOption,
    BackendOption,
    DeviceOption,
    FileOption,
    FirstSeedOption,
    PhysicsOption,
    ScenarioArgument,
    SettingsOption,
    ThreadsOption,
    completion_of,
    controller_names,
    find_backend,
)
from baselines.evaluation.console import check_file, say


def evaluate(  # noqa: PLR0913 the options of a command
    scenario: ScenarioArgument,
    controllers: Annotated[
        list[str],
        Argument(
            help="Controllers, with optional parameters: ssgiff:beta=0.02,refractory=10; or"
            " layers: social_odometry+sgiff+subsumption",
            autocompletion=controller_names,
        ),
    ],
    episodes: Annotated[int, Option(help="Number of episodes for each controller.")] = 30,
    seed: FirstSeedOption = 0,
    workers: Annotated[
        int | None, Option(help="Number of worker processes.", show_default="2; 1 for a GPU")
    ] = None,
    threads: ThreadsOption = 1,
    out: Annotated[
        str | None,
        Option(
            metavar="PATH",
            help="Folder of the dataset (Parquet), or an address: s3://bucket/x.",
            show_default="runs/<scenario>",
        ),
    ] = None,
    settings: SettingsOption = None,
    physics: PhysicsOption = None,
    form: Annotated[
        Literal["table", "json", "csv"], Option("--format", help="Format of the result.")
    ] = "table",
    series: Annotated[bool, Option("--series", help="Add the time series to JSON.")] = False,
    trajectories: Annotated[
        bool,
        Option("--trajectories", help="Write each robot's pose in every tick to OUT-trajectories."),
    ] = False,
    plot: Annotated[Path | None, FileOption(help="Draw the scores: .png, .pdf or .svg.")] = None,
    backend: BackendOption = "joblib",
    address: AddressOption = None,
    device: DeviceOption = "cpu",
) -> None:
    """Run controllers on a scenario and compare them: by round trips, or goals reached.

    All controllers run under the same seeds. Finished blocks of episodes are written to --out,
    and the progress bar counts their episodes. The same command later runs only what is missing:
    a stopped run repeats at most the unfinished blocks, one for each worker.
    """
    from baselines.evaluation import tables
    from baselines.evaluation.evaluate_options import EvaluateOptions
    from baselines.evaluation.experiment_config import changed_settings
    from baselines.evaluation.runner import check_kept, run_with_progress

    request = EvaluateOptions(scenario, controllers, episodes, seed, settings or [], physics)
    if workers is None:
        workers = 2 if device == "cpu" else 1
    spread = find_backend(backend, workers, threads, address, device)
    if plot:
        from baselines.evaluation.dataset_reader import EpisodeGroup
        from baselines.evaluation.figure_page import check_plot, save_figure
        from baselines.evaluation.figures.boxplot import boxplot

        check_plot(plot)
        if out and Path(out).resolve() in plot.resolve().parents:
            say(f"--plot lies inside --out: read the dataset as {out}/scenario=*/**/*.parquet")
    plan = request.plan(out, trajectories, device)
    run_with_progress(plan, spread)
    results, changes = plan.results(), changed_settings(plan.configurations[0].overrides)
    if plot:
        groups = list(map(EpisodeGroup.of, plan.configurations, plan.by_configuration()))
        save_figure(boxplot(groups, groups[0].kind.score, request.command), plot)
        say(f"wrote {plot}")
    if form == "table":
        Console().print(tables.report(results, changes))
    elif form == "json":
        typer.echo(tables.to_json(results, series, changes))
    else:
        typer.echo(tables.to_csv(results, changes))
    for line in tables.noise_lines(plan.configurations, plan.by_configuration()):
        say(line)
    check_kept(plan)


FIGURE_NAMES = (
    "boxplot", "curve", "on-path", "recruitment", "table", "paths", "learning", "weights",
)  # fmt: skip
"""Names of the kinds of figures, so that completion does not load their modules."""


PageStyleName = Literal["screen", "paper"]  # the page styles of figures


def plot(  # noqa: PLR0913 the options of a command
    kind: Annotated[
        str,
        Argument(
            metavar="KIND",
            help="Kind of figure: one of the above.",
            autocompletion=completion_of(FIGURE_NAMES),
        ),
    ],
    sources: Annotated[
        list[str],
        Argument(
            metavar="DATASET",
            help="Folders written by evaluate or reproduce; for learning, policy cards; for"
            " weights, controllers.",
        ),
    ],
    out: Annotated[
        list[Path], FileOption(metavar="FILE", help="File: .png, .pdf or .svg; may be repeated.")
    ],
    scenarios: Annotated[
        list[str] | None,
        Option("--scenario", metavar="NAME", help="Draw only this scenario; may be repeated."),
    ] = None,
    controllers: Annotated[
        list[str] | None,
        Option(
            "--controller",
            metavar="NAME",
            help="Draw only this controller: ssgiff, or ssgiff:beta=0.01; may be repeated.",
        ),
    ] = None,
    metric: Annotated[
        str | None,
        Option(
            help="Metric of boxplot, curve and table: messages, on_path_share, ...",
            show_default="the score",
        ),
    ] = None,
    x: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="Parameter on the x axis of curve: beta, task.n_robots, ...",
            show_default="the one that varies",
        ),
    ] = None,
    seed: Annotated[
        int | None, Option(min=0, help="Seed, for paths.", show_default="the first")
    ] = None,
    style: Annotated[
        PageStyleName,
        Option(help="screen: as wide as a page; paper: as wide as a column of a paper."),
    ] = "screen",
    caption: Annotated[
        bool, Option("--caption", help="Draw the caption, with command and code, below the panels.")
    ] = False,
) -> None:
    """Draw a figure of episodes that have been evaluated.

    **boxplot**: the score of each controller, or another --metric.

    **curve**: the same over a parameter of the controller or the scenario (beta, task.n_robots).

    **on-path**: share of the robots on the path over time.

    **recruitment**: share of the robots that have visited both areas, over time.

    **table**: the metric of each motion with each localisation.

    **paths**: a map of the robots' positions, from the files of evaluate --trajectories; without
    them one episode is run again. Also without a dataset: plot paths es1 nc ssgikf.

    **learning**: learning curves of trained policies, from the cards (.json) beside them.

    **weights**: the weight that each controller gives a message, over the own and the heard path:
    plot weights ssgikf ssgiff learned-weighting.

    A controller has the same colour in every figure. The metadata of the file, and FILE.json next
    to it, hold what the figure shows, the command and the version of the code. Examples:
    swarm-forage plot boxplot runs/es1 --out trips.png,
    swarm-forage plot curve runs/es1 --style paper --out beta.pdf
    """
    import baselines.evaluation.figures  # noqa: F401 enters the kinds
    from baselines.evaluation.figure_page import check_plot, draw_caption, page_style, save_figure
    from baselines.evaluation.figures.base import FIGURES, PlotOptions, check_options

    kind_of_figure = FIGURES[kind]
    for file in out:
        check_plot(file, "--out")
    chosen = tuple(scenarios or ()), tuple(controllers or ())
    options = PlotOptions(kind, sources, *chosen, metric, x, seed, style, caption)
    check_options(options)
    with page_style(style):
        figure = kind_of_figure.draw(options)
        if caption:
            draw_caption(figure)
        for file in out:
            save_figure(figure, file, f"swarm-forage plot {options.kind}")
            say(f"wrote {file}")


def watch(  # noqa: PLR0913 the options of a command
    scenario: ScenarioArgument,
    controllers: Annotated[
        list[str],
        Argument(
            metavar="CONTROLLER",
            help="A controller, with optional parameters: ssgiff:beta=0.02; --html shows two"
            " side by side.",
            autocompletion=controller_names,
        ),
    ],
    seed: Annotated[int, Option(help="Seed of the world.")] = 0,
    settings: SettingsOption = None,
    physics: PhysicsOption = None,
    speed: Annotated[
        float | None, Option(help="Speed, times real time.", show_default="10; 1 with --drive")
    ] = None,
    select: Annotated[int | None, Option(help="Robot whose belief is drawn, from 0 on.")] = None,
    start: Annotated[float, Option(help="Time of the episode to start from [s].")] = 0.0,
    seconds: Annotated[
        float | None, Option(help="Duration to show [s].", show_default="to the end")
    ] = None,
    drive: Annotated[
        int | None, Option(help="Index of a robot to drive with the arrow keys in the window.")
    ] = None,
    size: Annotated[int, Option(help="Width of the picture [px].")] = 720,
    video: Annotated[Path | None, FileOption(help="Write a video: .mp4 or looping .gif.")] = None,
    html: Annotated[Path | None, FileOption(help="Write a replay for the browser: .html.")] = None,
    frame: Annotated[Path | None, FileOption(help="Write the last moment shown: .png.")] = None,
) -> None:
    """Watch one episode.

    Without --video, --html or --frame a window opens. Its keys: space pauses, . steps, + and -
    change the speed, tab or a click selects a robot, escape deselects it, t b m switch trails,
    beliefs and messages (in waypoints: trails, estimates and lidar), s saves a picture to the
    current folder, q quits.
    """
    from baselines.evaluation import watch as watching
    from baselines.evaluation.evaluate_options import EvaluateOptions

    chosen = EvaluateOptions(scenario, controllers, 1, seed, settings or [], physics)
    if speed is None:
        speed = 10.0 if drive is None else 1.0
    options = watching.WatchOptions(speed, size, select, start, seconds, drive, video, html, frame)
    watching.watch(chosen, options)


def play(
    scenario: ScenarioArgument,
    controllers: Annotated[
        list[str],
        Argument(
            metavar="CONTROLLER", help="One or two controllers.", autocompletion=controller_names
        ),
    ],
    html: Annotated[Path, FileOption(help="The page to write: .html.")],
    settings: SettingsOption = None,
) -> None:
    """Write a page that runs the controllers in any browser, without a network.

    The page computes each episode in WebAssembly, as evaluate --physics kinematic does, and plays
    it. The visitor chooses a seed, changes robots, radio, noise, liars, obstacles and beta with
    sliders, and can drive a robot among the others.
    """
    from baselines.evaluation.evaluate_options import EvaluateOptions
    from baselines.evaluation.play import write_playground

    chosen = EvaluateOptions(scenario, controllers, 1, 0, settings or [], "kinematic")
    check_file("--html", html, (".html",))
    write_playground(chosen, html)
    say(f"wrote {html} ({html.stat().st_size / 1e6:.1f} MB)")
