"""DeviceArrayEnv, the batch API on a GPU: what goes in and comes out stays in its memory."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from swarm_forage_env.compiler import bind_grid
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs import grid
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.config import EnvConfig
from swarm_forage_env.envs.device_actions import DeviceActions, DeviceChoices, DeviceNumbers
from swarm_forage_env.envs.device_observer import DeviceObserver, DeviceRewards
from swarm_forage_env.envs.device_stepping import DeviceExchanges, DeviceStepper, DeviceTicks
from swarm_forage_env.envs.episodes import Seeds
from swarm_forage_env.errors import ConfigError

DEVICES = "cpu", "cuda"
"""Where the worlds of an environment can run."""

Told = dict[str, Any]


def array_env(scenario: Any = "es1", *, device: str = "cpu", **options: Any) -> Any:  # noqa: ANN401 an ArrayEnv, or one of a GPU
    """The batch API on a device: `ArrayEnv` on "cpu", `DeviceArrayEnv` on "cuda".

    The keywords are those of `ArrayEnv`. ConfigError for what does not run on that device.
    """
    check_device(device)
    return (ArrayEnv if device == "cpu" else DeviceArrayEnv)(scenario, **options)


def check_device(device: str) -> None:
    """ConfigError for a device on which worlds cannot run."""
    if device not in DEVICES:
        raise ConfigError(f"device={device!r}: must be {' or '.join(map(repr, DEVICES))}")


class DeviceArrayEnv:
    """W worlds side by side on a GPU, in each of which some robots learn.

        env = DeviceArrayEnv("es1", n_worlds=4096, physics="kinematic")
        observations, infos = env.reset(seed=0)
        actions = policy(torch.as_tensor(observations, device="cuda"))
        observations, rewards, terminated, truncated, infos = env.step(actions)

    What it gives are arrays of the GPU with `__cuda_array_interface__`, new ones in each step;
    what it takes may be of any library that has that: neither is copied. All is in the order of
    one stream, `stream`, at first CUDA's default stream, which is torch's too. A world is what it
    is on a CPU, to rounding. It differs from `ArrayEnv` in three ways: an action that is refused is
    found when it is too late for the step alone; the CPU draws the seeds of resets, and numbers
    that are randomised; and what `refusals` lists is refused.
    """

    def __init__(
        self,
        scenario: Any = "es1",  # noqa: ANN401 a name, a file or a scenario of any task
        n_worlds: int = 1,
        controller: Any = None,  # noqa: ANN401 a name, or a controller
        stagger: bool = False,
        **options: Any,  # noqa: ANN401 as parallel_env
    ) -> None:
        """Make the worlds under the keywords of `parallel_env`; `reset` starts their episodes."""
        self._host = host = ArrayEnv(scenario, n_worlds, controller, stagger, **options)
        _check(host)
        self.n_worlds, self.learners, self.config = host.n_worlds, host.learners, host.config
        self.action_space, self.observation_space = host.action_space, host.observation_space
        self.action_layout, self.observation_layout = host.action_layout, host.observation_layout
        self.max_cycles = host.max_cycles
        self.loop = loop = DeviceLoop(host.loop)
        host.episodes.run_on(loop)
        is_discrete = host.actions.form.is_discrete
        self._actions: DeviceActions
        self._actions = (DeviceChoices if is_discrete else DeviceNumbers)(host, loop)
        self._observe = DeviceObserver(host, loop)
        self._rewards = DeviceRewards(host, loop.task.potential, loop)
        self._stepper: DeviceStepper
        by_exchange = host.config.step_on == "exchange"
        self._stepper = (DeviceExchanges if by_exchange else DeviceTicks)(host, loop)
        self._numbers = loop.memory.to_device(host.learner_numbers)
        self._never = loop.memory.to_device(np.zeros(self.n_worlds, np.bool_))
        self._log = bind_grid(grid.write_log, {"log": loop.task.log[loop.layers.has_beliefs]})

    @property
    def is_over(self) -> Any:  # noqa: ANN401 an array
        """The episode of each world has ended: it must be reset. An array of the CPU."""
        return self._host.is_over

    @property
    def stream(self) -> int:
        """The address of the stream of CUDA in whose order all is done; 0: the default stream.

        Whoever works in another one says so before a reset or a step, as the wrappers for torch
        do: `env.stream = torch.cuda.current_stream().cuda_stream`. It waits for the one before.
        """
        return self.loop.memory.stream

    @stream.setter
    def stream(self, address: int) -> None:
        self.loop.memory.change_stream(address)

    @property
    def host(self) -> ArrayEnv:
        """The environment on the CPU that makes the worlds: its names, spaces and episodes.

        Its records are as old as the last `download`.
        """
        return self._host

    def reset(
        self,
        seed: Seeds = None,
        worlds: Any = None,  # noqa: ANN401 a mask, or numbers
        options: Mapping[str, Any] | None = None,
    ) -> tuple[Any, Told]:
        """Start worlds anew, all unless `worlds` is a mask or numbers of some; observe all.

        As `ArrayEnv.reset`. Raises what went wrong on the GPU before.
        """
        self.loop.check()
        new = self._host.begin(seed, worlds, options)
        is_new = np.zeros(self.n_worlds, np.int8)
        is_new[new] = True
        self._is_new = self.loop.memory.to_device(is_new)
        drawn = self._host.episodes.drawn.items()
        self._drawn: Told = {name: self.loop.memory.to_device(each) for name, each in drawn}
        nothing = self._rewards.begin(self._is_new, self._actions.raw)
        return self._observe(self._actions.raw, self._is_new, False), self._infos(nothing)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, Told]:  # noqa: ANN401 arrays of the GPU
        """One decision; observations, rewards, terminated, truncated, infos.

        `actions` lie on the GPU: float32 of shape (worlds, learners, numbers), or where they are
        choices whole numbers of shape (worlds, learners). ConfigError for one that is out of
        bounds, before anything moves, and for what went wrong in the step before.
        """
        self._host.episodes.check_running()
        loop, given = self.loop, self._actions.taken(actions)
        self._actions.check(given)
        loop.check()
        self._actions.take(given)
        self._stepper.run()
        unshaped, rewards = self._rewards()
        seen = self._observe(self._actions.raw, self._is_new, True)
        truncated = loop.memory.to_device(self._host.is_over)
        return seen, rewards, self._never, truncated, self._infos(unshaped)

    def log(self) -> Any:  # noqa: ANN401 an array of the GPU
        """What is logged of each learner, as `ArrayEnv.log`: a new array."""
        at = self.loop.arrays
        shape = self.n_worlds, len(self.learners), len(self._host.infos)
        out = self.loop.memory.empty(shape, np.float64)
        self._log[self.loop.launch](at["robots"], at["minds"], at["worlds"], self._numbers, out)
        return out

    def download(self) -> ArrayEnv:
        """The environment on the CPU, as it stands: its log, its state, its scenes.

        A later step goes on from the GPU, whatever was done to it.
        """
        self.loop.check()
        self.loop.download()
        return self._host

    def _infos(self, unshaped: Any) -> Told:  # noqa: ANN401 an array of the GPU
        """What is told beside: the reward, whose action counts, and what was drawn."""
        acts = self._stepper.acts()
        told = {} if acts is None else {"acts": acts}
        return {"unshaped_reward": unshaped, **told, **self._drawn}


def refusals(config: EnvConfig) -> dict[str, bool]:
    """What a GPU does not do, by the option that asks for it, and whether these options do."""
    return {f"reward={config.reward!r}": config.reward not in ("own", "team")}


def _check(host: ArrayEnv) -> None:
    """ConfigError for what does not run on a GPU."""
    for option, is_asked in refusals(host.config).items():
        if is_asked:
            raise ConfigError(f"{option}: runs on a CPU only; leave it out, or take device='cpu'")
    for part in host.observer.parts:
        if not hasattr(part, "put"):
            raise ConfigError(
                f"observation: {type(part).__name__} is written in NumPy, which runs on a CPU only;"
                " leave it out, or take device='cpu'"
            )
