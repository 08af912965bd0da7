"""Run one episode and pass its scenes to windows and recorders."""

import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace
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

Take = Callable[[Scene], bool | None]
"""Function that takes each scene, before `start` for trails only; true ends the episode."""

Painted = AbstractContextManager[Take]
"""Context of a recorder, which writes its file on exit, but not after an error or interrupt."""

MAX_CONTROLLERS = 2  # maximum number of controllers side by side


@dataclass(frozen=True)
class WatchOptions:
    """Options of the command `watch`: how an episode is shown."""

    speed: float = 10.0  # multiple of real time
    size: int = 720  # width of pictures [px]
    select: int | None = None  # the robot whose beliefs are drawn
    start: float = 0.0  # simulated time from which the episode is shown [s]
    seconds: float | None = None  # simulated time that is shown [s]; None: to the end
    drive: int | None = None  # the robot that the user drives with the arrow keys
    video: Path | None = None
    html: Path | None = None
    frame: Path | None = None


def watch(chosen: EvaluateOptions, options: WatchOptions) -> None:
    """Run one episode and show it; two controllers run side by side under the same seed."""
    configurations = chosen.configurations()
    _check_number(chosen.controllers, options)
    stage = stage_of(configurations[0].scenario, configurations[0].label)
    command = _command(chosen, options)
    options = _checked(options, stage)
    if options.drive is not None:
        _drive(configurations[0], chosen.seeds()[0], stage, options)
        return
    episodes = [_scenes(each, chosen.seeds()[0], stage, options) for each in configurations]
    replay = _replay(stage, chosen, options, command) if options.html else None
    with ExitStack() as stack:
        takes = [stack.enter_context(each) for each in _painted(stage, options)]
        for scenes in zip(*episodes, strict=True):
            for swarm, scene in enumerate(scenes):
                if replay:
                    replay.add(scene, swarm)
            if any(take(scenes[0]) for take in takes):
                break
    if replay and options.html:
        replay.write(options.html)
    for file in filter(None, (options.video, options.html, options.frame)):
        say(f"wrote {file} ({file.stat().st_size / 1e6:.1f} MB)")


def _drive(configuration: ExperimentConfig, seed: int, stage: Stage, options: WatchOptions) -> None:
    """Run an episode in which the arrow keys move a robot. ImportError without pygame."""
    from swarm_forage_env.envs.array_env import ArrayEnv
    from swarm_forage_env.envs.keywords import OwnName
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
        physics=OwnName(configuration.physics),
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


def _command(chosen: EvaluateOptions, options: WatchOptions) -> str:
    """Return the command line that shows the same episode again, without default options.

    Files that it writes are named without their folder.
    """
    words = [f"--set={each}" for each in chosen.settings] + [f"--seed={chosen.seed}"]
    words += [f"--physics={chosen.physics}"] if chosen.physics else []
    for name, value in vars(options).items():
        if value != vars(WatchOptions)[name]:
            shown = value.name if isinstance(value, Path) else value
            words.append(f"--{name}={shown:g}" if isinstance(shown, float) else f"--{name}={shown}")
    return shlex.join(["swarm-forage", "watch", chosen.scenario, *chosen.controllers, *words])


def _scenes(
    configuration: ExperimentConfig, seed: int, stage: Stage, options: WatchOptions
) -> Iterator[Scene]:
    scenario, controller = configuration.scenario, configuration.controller
    loop, ticks = Loop(scenario, controller, [seed], configuration.physics), _ticks(stage, options)
    loop.run(ticks[0])
    for tick in ticks:
        yield loop.scene()
        if tick < ticks[-1]:
            loop.step()


def _ticks(stage: Stage, options: WatchOptions) -> range:
    """Return the ticks that are shown or leave trails."""
    first = max(0, round((options.start - TRAIL) / stage.tick))
    last = round((options.start + (options.seconds or 0.0)) / stage.tick)
    return range(first, last + 1)


def _replay(stage: Stage, chosen: EvaluateOptions, options: WatchOptions, command: str) -> Replay:
    second = chosen.controllers[1] if len(chosen.controllers) > 1 else None
    colours = tuple(map(colour_of, chosen.controllers))
    opening = Opening(options.start, options.speed, options.select, second, colours)
    return Replay(stage, chosen.seeds()[0], command, len(_ticks(stage, options)), opening)


def _painted(stage: Stage, options: WatchOptions) -> Sequence[Painted]:
    """Return the recorders of the first swarm, or a window. ImportError without pygame."""
    if options.html and not options.video and not options.frame:
        return []
    from baselines.evaluation import image_recorders as images

    painted = [images.video(stage, options)] if options.video else []
    painted += [images.still(stage, options)] if options.frame else []
    return painted or [images.live_window(stage, options)]


def _checked(options: WatchOptions, stage: Stage) -> WatchOptions:
    """Return the options with their length filled in; ConfigError if they cannot be shown."""
    checked_speed(options.speed)
    size = checked_size(options.size)
    for option, robot in (("--select", options.select), ("--drive", options.drive)):
        if robot is not None and not 0 <= robot < stage.n_robots:
            raise ConfigError(
                f"{option}={robot}: must be 0 to {stage.n_robots - 1}, a robot of {stage.scenario}"
            )
    files = options.video or options.html or options.frame
    if options.drive is not None and (options.start or files):
        raise ConfigError(
            f"--drive={options.drive}: a robot is driven in a window, from the start of an"
            " episode; leave out --start, --video, --html and --frame"
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
    return replace(options, seconds=seconds, size=size)
