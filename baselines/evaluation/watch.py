"""Run one episode and pass its scenes to windows and recorders."""

import shlex
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import chain
from pathlib import Path

from baselines.evaluation.console import check_file, say
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.plot_style import colour_of
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.rendering.layout import checked_size, checked_speed
from swarm_forage_env.rendering.replay import Opening, Replay
from swarm_forage_env.rendering.trails import TRAIL
from swarm_forage_env.rendering.video import FORMATS
from swarm_forage_env.scene import Scene, Stage
from swarm_forage_env.task import stage_of


class Recorder(ABC):
    """Receives an episode's scenes; those before `start` are for trails only."""

    @abstractmethod
    def take(self, scene: Scene) -> bool:
        """Receive the next scene; return false to stop the episode."""

    def close(self) -> None:  # noqa: B027 some have nothing to finish
        """Finish after the last scene."""

    def discard(self) -> None:  # noqa: B027 some have written nothing yet
        """Remove what is half-made, after an error."""


class ReplayRecorder(Recorder):
    """Adds the scenes of a swarm to a replay, and writes it as one HTML file if it is the first."""

    def __init__(self, file: Path, replay: Replay, swarm: int = 0) -> None:
        """Start with an empty recording."""
        self._file, self._replay, self._swarm = file, replay, swarm

    def take(self, scene: Scene) -> bool:
        """Record the scene."""
        self._replay.add(scene, self._swarm)
        return True

    def close(self) -> None:
        """Write the HTML file."""
        if self._swarm == 0:
            self._replay.write(self._file)


MAX_CONTROLLERS = 2
"""Controllers that are shown side by side, at most."""


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
    drive: int | None = None
    """The robot that the user drives by the arrow keys, in a window."""
    video: Path | None = None
    html: Path | None = None
    frame: Path | None = None

    @property
    def in_a_window(self) -> bool:
        """Whether no file is written, so that a window opens."""
        return not (self.video or self.html or self.frame)

    @property
    def needs_pictures(self) -> bool:
        """Whether anything is painted, which takes pygame."""
        return not self.html or bool(self.video or self.frame)


def watch(chosen: EvaluateOptions, options: WatchOptions) -> None:
    """Run one episode and show it; of two controllers side by side, under the same seed."""
    configurations = chosen.configurations()
    _check_number(chosen.controllers, options)
    stage = stage_of(configurations[0].scenario, configurations[0].label)
    command = command_of(chosen, options)
    options = _checked(options, stage)
    if options.drive is not None:
        _drive(configurations[0], chosen.seeds()[0], stage, options)
        return
    recorders = _recorders(stage, chosen, options, command)
    _record(configurations, chosen.seeds()[0], stage, options, recorders)
    for file in (options.video, options.html, options.frame):
        if file:
            say(f"wrote {file} ({file.stat().st_size / 1e6:.1f} MB)")


def _record(
    configurations: Sequence[ExperimentConfig],
    seed: int,
    stage: Stage,
    options: WatchOptions,
    recorders: Sequence[Sequence[Recorder]],
) -> None:
    episodes = [_scenes(each, seed, stage, options) for each in configurations]
    try:
        for scenes in zip(*episodes, strict=True):
            pairs = zip(recorders, scenes, strict=True)
            watched = [each.take(scene) for several, scene in pairs for each in several]
            if not all(watched):
                break
    except BaseException:  # also when the user stops it: half a film is no film
        for recorder in chain(*recorders):
            recorder.discard()
        raise
    for recorder in chain(*recorders):
        recorder.close()


def _drive(configuration: ExperimentConfig, seed: int, stage: Stage, options: WatchOptions) -> None:
    """Run an episode in which the arrow keys move a robot, and report its score.

    It ends after `options.seconds`, or when the user closes the window. ImportError without pygame.
    """
    from swarm_forage_env.envs.array_env import ArrayEnv
    from swarm_forage_env.envs.manual_policy import action_of
    from swarm_forage_env.rendering.window import Window

    assert options.drive is not None
    assert options.seconds is not None
    scenario, robot = configuration.scenario, options.drive
    window = Window(stage, options.size, options.speed, options.select)
    env = ArrayEnv(
        scenario,
        controller=configuration.controller,
        learn="motion",
        learners=[robot],
        reflexes=False,
        physics=configuration.physics,
        decision_period=1,
    )
    env.reset(seed)
    window.drive(robot)
    scene = env.loop.scene()
    window.show(scene)
    while not window.closed and scene.time < options.seconds - 1e-9:
        env.step(action_of(window.arrows, env.action_layout.names)[None, None])
        scene = env.loop.scene()
        window.show(scene)
    window.close()
    score = f"{scene.round_trips[robot]} round trips"
    if scene.localised is not None:
        score = f"{scene.localised.right[robot]} goals reached"
    say(f"robot {robot}: {score} of the swarm's {scene.total}, in {scene.time:g} s")


def _check_number(controllers: Sequence[str], options: WatchOptions) -> None:
    if len(controllers) > MAX_CONTROLLERS:
        raise ConfigError(
            f"{len(controllers)} controllers: at most {MAX_CONTROLLERS} are shown side by side"
        )
    if len(controllers) > 1 and (options.html is None or options.video or options.frame):
        raise ConfigError(
            f"{' and '.join(controllers)}: only a replay shows two side by side; add --html FILE"
            " without --video and --frame, or name one controller"
        )


def command_of(chosen: EvaluateOptions, options: WatchOptions) -> str:
    """The command line that shows the same again, with every option that is not the usual one."""
    words = [f"--set={each}" for each in chosen.settings] + [f"--seed={chosen.seed}"]
    words += [f"--physics={chosen.physics}"] if chosen.physics else []
    for each in fields(WatchOptions):
        value = getattr(options, each.name)
        if value != each.default:
            words.append(
                f"--{each.name}={value:g}" if isinstance(value, float) else f"--{each.name}={value}"
            )
    return shlex.join(["swarm-forage", "watch", chosen.scenario, *chosen.controllers, *words])


def _scenes(
    configuration: ExperimentConfig, seed: int, stage: Stage, options: WatchOptions
) -> Iterator[Scene]:
    scenario, controller = configuration.scenario, configuration.controller
    loop = Loop(scenario, controller, [seed], configuration.physics)
    first = max(0, round((options.start - TRAIL) / stage.tick))
    last = round((options.start + (options.seconds or 0.0)) / stage.tick)
    for tick in range(last + 1):
        if tick >= first:
            yield loop.scene()
        if tick < last:
            loop.step()


def _recorders(
    stage: Stage, chosen: EvaluateOptions, options: WatchOptions, command: str
) -> list[list[Recorder]]:
    recorders: list[list[Recorder]] = [[] for _ in chosen.controllers]
    if options.html:
        beside = chosen.controllers[1] if len(chosen.controllers) > 1 else None
        colours = tuple(map(colour_of, chosen.controllers))
        opening = Opening(options.start, options.speed, options.select, beside, colours)
        replay = Replay(stage, chosen.seeds()[0], command, opening=opening)
        for swarm, own in enumerate(recorders):
            own.append(ReplayRecorder(options.html, replay, swarm))
    if options.needs_pictures:
        recorders[0] += _image_recorders(stage, options)
    return recorders


def _image_recorders(stage: Stage, options: WatchOptions) -> list[Recorder]:
    """The recorders that paint. ImportError without pygame."""
    from baselines.evaluation.image_recorders import LiveWindow, StillRecorder, VideoRecorder
    from swarm_forage_env.rendering.window import Window

    size, select, start = options.size, options.select, options.start
    found: list[Recorder] = []
    if options.video:
        found.append(VideoRecorder(options.video, stage, size, select, options.speed, start))
    if options.frame:
        found.append(StillRecorder(options.frame, stage, size, select))
    if options.in_a_window:
        found.append(LiveWindow(Window(stage, size, options.speed, select), start))
    return found


def _check_robot(option: str, robot: int | None, stage: Stage) -> None:
    if robot is not None and not 0 <= robot < stage.n_robots:
        raise ConfigError(
            f"{option}={robot}: must be 0 to {stage.n_robots - 1}, a robot of {stage.scenario}"
        )


def _check_drive(options: WatchOptions, stage: Stage) -> None:
    """ConfigError for a robot that cannot be driven by hand."""
    if options.drive is None:
        return
    _check_robot("--drive", options.drive, stage)
    if not options.in_a_window or options.start:
        raise ConfigError(
            f"--drive={options.drive}: a robot is driven in a window, from the start on; leave out"
            " --start, --video, --html and --frame"
        )


def _checked(options: WatchOptions, stage: Stage) -> WatchOptions:
    """Check the options and fill in the length; ConfigError for what cannot be shown."""
    checked_speed(options.speed)
    checked_size(options.size)
    _check_robot("--select", options.select, stage)
    _check_drive(options, stage)
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
