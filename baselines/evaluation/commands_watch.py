"""The command `watch`: show one episode in a window, or as a video, a replay or a still."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from baselines.evaluation.common_options import (
    PhysicsOption,
    ScenarioArgument,
    SettingsOption,
    controller_names,
    path,
)


def watch(  # noqa: PLR0913 the options of a command
    scenario: ScenarioArgument,
    controllers: Annotated[
        list[str],
        Argument(
            metavar="CONTROLLER",
            help="A name, with parameters if need be: ssgiff:beta=0.02; of two, --html shows both"
            " side by side.",
            autocompletion=controller_names,
        ),
    ],
    seed: Annotated[int, Option(help="Seed of the world.")] = 0,
    settings: SettingsOption = None,
    physics: PhysicsOption = None,
    speed: Annotated[
        float | None, Option(help="Multiple of real time.", show_default="10; 1 with --drive")
    ] = None,
    select: Annotated[
        int | None, Option(help="Draw what this robot believes; they count from 0.")
    ] = None,
    start: Annotated[float, Option(help="Show from this time of the episode on [s].")] = 0.0,
    seconds: Annotated[
        float | None, Option(help="Show so much of the episode [s].", show_default="to its end")
    ] = None,
    drive: Annotated[
        int | None, Option(help="Drive this robot yourself: hold the arrow keys in the window.")
    ] = None,
    size: Annotated[int, Option(help="Width of the picture [px].")] = 720,
    video: Annotated[
        Path | None, Option(parser=path, help="Write a video: an .mp4, or a looping .gif.")
    ] = None,
    html: Annotated[
        Path | None, Option(parser=path, help="Write a replay for the browser: an .html file.")
    ] = None,
    frame: Annotated[
        Path | None, Option(parser=path, help="Write the last moment shown: a .png file.")
    ] = None,
) -> None:
    """Watch one episode.

    Without --video, --html or --frame a window opens. Its keys: space pauses, . steps, + and -
    change the speed, tab or a click selects a robot, escape none, t b m switch trails, beliefs
    and messages (of waypoints: trails, estimates and lidar), s saves a picture to the current
    folder, q quits.
    """
    from baselines.evaluation import watch as watching
    from baselines.evaluation.evaluate_options import EvaluateOptions

    chosen = EvaluateOptions(scenario, controllers, 1, seed, settings or [], physics)
    if speed is None:
        speed = 10.0 if drive is None else 1.0
    options = watching.WatchOptions(speed, size, select, start, seconds, drive, video, html, frame)
    watching.watch(chosen, options)
