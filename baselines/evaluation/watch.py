"""Run one episode and pass its scenes to windows and recorders."""

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from baselines.evaluation.console import say
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.output_files import check_file
from baselines.evaluation.recorders import (
    LiveWindow,
    Recorder,
    ReplayRecorder,
    StillRecorder,
    VideoRecorder,
)
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.rendering.trails import TRAIL
from swarm_forage_env.rendering.video import FORMATS
from swarm_forage_env.rendering.window import Window, checked_speed
from swarm_forage_env.scene import Scene, Stage
from swarm_forage_env.task import stage_of


@dataclass(frozen=True)
class WatchOptions:
    """Options of the command `watch`: how an episode is shown."""

    speed: float = 10.0
    """Multiple of real time."""

    size: int = 720
    """Width of pictures [px]."""

    select: int | None = None
    """The robot whose beliefs are drawn."""

    start: float = 0.0
    """Time of the episode at which it begins to be shown [s]."""

    seconds: float | None = None
    """For how long, in the episode's time [s]; None: to its end."""

    video: Path | None = None
    html: Path | None = None
    frame: Path | None = None

    @property
    def in_a_window(self) -> bool:
        """Whether no file is written, so that a window opens."""
        return not (self.video or self.html or self.frame)


def watch(chosen: EvaluateOptions, options: WatchOptions) -> None:
    """Run one episode and show it.

    ConfigError or UnknownNameError for whatever cannot be used, before anything runs.
    """
    (configuration,) = chosen.configurations()
    seed = chosen.seeds()[0]
    stage = stage_of(configuration.scenario, configuration.label)
    options = _checked(options, stage)
    recorders = _recorders(stage, seed, options, command_of(chosen))
    try:
        for scene in _scenes(configuration, seed, stage, options):
            watched = [recorder.take(scene) for recorder in recorders]
            if not all(watched):
                break
    except BaseException:  # also when the user stops it: half a film is no film
        for recorder in recorders:
            recorder.discard()
        raise
    for recorder in recorders:
        recorder.close()
    for file in (options.video, options.html, options.frame):
        if file:
            say(f"wrote {file} ({file.stat().st_size / 1e6:.1f} MB)")


def command_of(chosen: EvaluateOptions) -> str:
    """The command line that shows the same episode again."""
    options = [f"--set={each}" for each in chosen.settings] + [f"--seed={chosen.seed}"]
    options += [f"--physics={chosen.physics}"] if chosen.physics else []
    return shlex.join(["swarm-forage", "watch", chosen.scenario, *chosen.controllers, *options])


def _scenes(
    configuration: ExperimentConfig, seed: int, stage: Stage, options: WatchOptions
) -> Iterator[Scene]:
    """The scenes to show, one a tick, after those that trails start from."""
    scenario, controller = configuration.scenario, configuration.controller
    loop = Loop(scenario, controller, [seed], configuration.physics)
    first = max(0, round((options.start - TRAIL) / stage.tick))
    last = round((options.start + (options.seconds or 0.0)) / stage.tick)
    for tick in range(last + 1):
        if tick >= first:
            yield loop.scene()
        if tick < last:
            loop.step()


def _recorders(stage: Stage, seed: int, options: WatchOptions, command: str) -> Sequence[Recorder]:
    """The recorders that the options ask for."""
    size, select, start = options.size, options.select, options.start
    recorders: list[Recorder] = []
    if options.video:
        recorders.append(VideoRecorder(options.video, stage, size, select, options.speed, start))
    if options.html:
        from swarm_forage_env.rendering.replay import Replay

        recorders.append(ReplayRecorder(options.html, Replay(stage, seed, command), start))
    if options.frame:
        recorders.append(StillRecorder(options.frame, stage, size, select))
    if options.in_a_window:
        recorders.append(LiveWindow(Window(stage, size, options.speed, select), start))
    return recorders


def _checked(options: WatchOptions, stage: Stage) -> WatchOptions:
    """Check the options and fill in the length; ConfigError for what cannot be shown."""
    checked_speed(options.speed)
    if options.select is not None and not 0 <= options.select < stage.n_robots:
        raise ConfigError(
            f"--select={options.select}: must be 0 to {stage.n_robots - 1}, a robot of"
            f" {stage.scenario}"
        )
    if not 0.0 <= options.start < stage.duration:
        raise ConfigError(
            f"--start={options.start:g}: must be 0 to less than the {stage.duration:g} s of an"
            " episode"
        )
    rest = stage.duration - options.start
    seconds = rest if options.seconds is None else options.seconds
    if not 0.0 < seconds <= rest:
        raise ConfigError(
            f"--seconds={seconds:g}: must be above 0 and at most {rest:g} [s], the rest of an"
            " episode"
        )
    for option, file, endings in (
        ("--video", options.video, FORMATS),
        ("--html", options.html, (".html",)),
        ("--frame", options.frame, (".png",)),
    ):
        if file:
            check_file(option, file, endings)
    return replace(options, seconds=seconds)
