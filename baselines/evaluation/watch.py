"""Watch one episode: run it, and hand its scenes to whatever shows them."""

import shlex
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from baselines.evaluation.configuration import Configuration
from baselines.evaluation.files import check_file
from baselines.evaluation.request import Request
from baselines.evaluation.sinks import ReplaySink, Sink, StillSink, VideoSink, WindowSink
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.rendering.memory import TRAIL
from swarm_forage_env.rendering.scene import Scene, Stage, scene_of, stage_of
from swarm_forage_env.rendering.video import FORMATS
from swarm_forage_env.rendering.window import Window, checked_speed
from swarm_forage_env.scenario import Scenario


@dataclass(frozen=True)
class Showing:
    """How an episode is shown."""

    speed: float = 10.0
    """Multiple of real time."""

    size: int = 720
    """Width of pictures [px]."""

    select: int | None = None
    """The robot whose beliefs are drawn."""

    start: float = 0.0
    """Time of the episode at which showing begins [s]."""

    seconds: float | None = None
    """For how long, in the episode's time [s]; None: to its end."""

    video: Path | None = None
    html: Path | None = None
    frame: Path | None = None

    @property
    def in_a_window(self) -> bool:
        """Nothing is to be written."""
        return not (self.video or self.html or self.frame)


def watch(request: Request, showing: Showing, say: Callable[[str], None]) -> None:
    """Run the one episode that is asked for, and show it.

    ConfigError or UnknownNameError for whatever cannot be used, before anything runs.
    """
    (configuration,) = request.configurations()
    seed = request.seeds()[0]
    stage = stage_of(configuration.scenario, configuration.label)
    showing = _checked(showing, stage)
    sinks = _sinks(stage, seed, showing, command_of(request))
    try:
        for scene in _scenes(configuration, seed, stage, showing):
            watched = [sink.take(scene) for sink in sinks]
            if not all(watched):
                break
    except BaseException:  # also when the user stops it: half a film is no film
        for sink in sinks:
            sink.discard()
        raise
    for sink in sinks:
        sink.close()
    for file in (showing.video, showing.html, showing.frame):
        if file:
            say(f"wrote {file} ({file.stat().st_size / 1e6:.1f} MB)")


def command_of(request: Request) -> str:
    """The command that shows the same episode again."""
    options = [f"--set={each}" for each in request.settings] + [f"--seed={request.seed}"]
    options += [f"--physics={request.physics}"] if request.physics else []
    return shlex.join(["swarm-forage", "watch", request.scenario, *request.controllers, *options])


def _scenes(
    configuration: Configuration, seed: int, stage: Stage, showing: Showing
) -> Iterator[Scene]:
    """The scenes to show, one a tick, and those before them from which trails come."""
    scenario = configuration.scenario
    assert isinstance(scenario, Scenario)  # stage_of has refused all others
    loop = ControlLoop(scenario, configuration.recipe, [seed], configuration.physics)
    first = max(0, round((showing.start - TRAIL) / stage.tick))
    last = round((showing.start + (showing.seconds or 0.0)) / stage.tick)
    for tick in range(last + 1):
        if tick >= first:
            yield scene_of(loop.world, loop.controller.estimator.situation)
        if tick < last:
            loop.step()


def _sinks(stage: Stage, seed: int, showing: Showing, command: str) -> Sequence[Sink]:
    """Everything that takes the scenes."""
    size, select, start = showing.size, showing.select, showing.start
    sinks: list[Sink] = []
    if showing.video:
        sinks.append(VideoSink(showing.video, stage, size, select, showing.speed, start))
    if showing.html:
        from swarm_forage_env.rendering.replay import Replay

        sinks.append(ReplaySink(showing.html, Replay(stage, seed, command), start))
    if showing.frame:
        sinks.append(StillSink(showing.frame, stage, size, select))
    if showing.in_a_window:
        sinks.append(WindowSink(Window(stage, size, showing.speed, select), start))
    return sinks


def _checked(showing: Showing, stage: Stage) -> Showing:
    """The same with its length filled in; ConfigError for what cannot be shown."""
    checked_speed(showing.speed)
    if showing.select is not None and not 0 <= showing.select < stage.n_robots:
        raise ConfigError(
            f"--select={showing.select}: must be 0 to {stage.n_robots - 1}, a robot of"
            f" {stage.scenario}"
        )
    if not 0.0 <= showing.start < stage.duration:
        raise ConfigError(
            f"--start={showing.start:g}: must be 0 to less than the {stage.duration:g} s of an"
            " episode"
        )
    rest = stage.duration - showing.start
    seconds = rest if showing.seconds is None else showing.seconds
    if not 0.0 < seconds <= rest:
        raise ConfigError(
            f"--seconds={seconds:g}: must be above 0 and at most {rest:g} [s], the rest of an"
            " episode"
        )
    for option, file, endings in (
        ("--video", showing.video, FORMATS),
        ("--html", showing.html, (".html",)),
        ("--frame", showing.frame, (".png",)),
    ):
        if file:
            check_file(option, file, endings)
    return replace(showing, seconds=seconds)
