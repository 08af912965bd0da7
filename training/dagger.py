"""DAgger for the confidence weighting: supervised learning from the true errors of estimates.

The weights influence which exchanges occur. Therefore each round runs new worlds under the current
network, records all exchanges, and fits the network to minimise the error of the merged estimates.

Source: Ross2011, A Reduction of Imitation Learning and Structured Prediction to No-Regret Online
Learning (DAgger); here without data of earlier rounds, and with a falling learning rate.
"""

import operator
import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import torch
from torch import Tensor, nn

from baselines.evaluation.backends import JoblibBackend, run_in_order
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.observed_fields import FieldLayout
from training.exchanges import Exchanges, record_exchanges
from training.experiment import Experiment, worlds_per_scenario
from training.learned_weighting import (
    EXCHANGE_NETWORK,
    REMEMBERED,
    REPUTATION_NETWORK,
    WeightingNetwork,
    flatten,
    network_over,
    unflatten,
)
from training.policy_file import Policy, Weights, load_policy, observation_layout
from training.training_loop import NetworkTraining, ProgressLogger, run

HIDDEN = 16  # hidden units: supervised learning can fit more of them than a search
GRADIENT_STEPS = 500  # steps of Adam in a round
LEARNING_RATE = 0.01  # rate of Adam in the first round; it falls linearly to zero over the budget


class WeightingActor:
    """The network of `training.learned_weighting` in torch, with the arrays of a policy file."""

    def __init__(
        self,
        layout: FieldLayout,
        hidden: int = HIDDEN,
        architecture: WeightingNetwork = EXCHANGE_NETWORK,
    ) -> None:
        """Initialise the weights of the hidden units orthogonally, all others to zero."""
        self.architecture, self.sizes = architecture, {"hidden": hidden}
        shapes = architecture.shapes(self.sizes)
        self.arrays = {name: torch.zeros(shape) for name, shape in shapes.items()}
        nn.init.orthogonal_(self.arrays["hidden.weight"], 2.0**0.5)
        for array in self.arrays.values():
            array.requires_grad_()
        self._columns = layout.columns("encounter")
        self._scales = torch.tensor(architecture.scales).T  # unit, centre and spread of each input

    def to_numpy(self) -> dict[str, Float32[Array, "..."]]:
        """Copy all parameters to NumPy arrays, named as in a policy file."""
        return {name: array.detach().numpy().copy() for name, array in self.arrays.items()}

    def load_numpy(self, arrays: Weights) -> None:
        """Set all parameters from NumPy arrays, by name."""
        with torch.no_grad():
            for name, array in self.arrays.items():
                array.copy_(torch.from_numpy(arrays[name]))

    def __call__(self, observed: Tensor) -> Tensor:
        """Return the weight g of each area; 0 for areas that the network does not weigh.

        It weighs areas that both robots know; the reputation network weighs all areas of which an
        estimate was received.
        """
        exchange = {name: observed[:, each] for name, each in self._columns.items()}
        columns = {**exchange, "own_p_elsewhere": exchange["own_p"].flip(1)}
        columns |= {name: exchange[name].expand(-1, 2) for name in ("frames", "range")}
        mask = exchange["heard_known"]
        if self.architecture is REPUTATION_NETWORK:
            remembered = observed[:, -len(REMEMBERED) :].T[:, :, None].expand(-1, -1, 2)
            columns |= zip(REMEMBERED, remembered, strict=True)
        else:
            mask = mask * exchange["own_known"]
        features = torch.stack([columns[name] for name in self.architecture.features], 2)
        unit, centre, spread = self._scales
        x = (torch.log1p(features / unit) - centre) / spread
        w, direct = self.arrays, self.arrays["direct.weight"]
        hidden = torch.tanh(x @ w["hidden.weight"].T + w["hidden.bias"])
        ahead = exchange["own_p"] - exchange["heard_p"]
        network = x @ direct[:-1] + hidden @ w["output.weight"] + w["output.bias"]
        return torch.sigmoid((1.0 + direct[-1]) * ahead + network) * mask


def train(experiment: Experiment, say: Callable[[str], None]) -> Policy:
    """Run or resume an experiment with DAgger, and return the best policy."""
    return load_policy(run(DAggerTraining(experiment), experiment, "round", say))


class DAggerTraining(NetworkTraining):
    """A resumable DAgger training."""

    def __init__(self, experiment: Experiment) -> None:
        torch.manual_seed(experiment.seed)
        self._scenarios = experiment.scenarios_by_name
        layout = observation_layout("weighting", next(iter(self._scenarios.values())))
        architecture = network_over(experiment.base_controller.estimator)
        policy = experiment.policy_of("weighting")  # that of the controller, if learned
        hidden = HIDDEN if policy is None else policy.card.layers["weighting"].sizes["hidden"]
        self._actor = actor = WeightingActor(layout, hidden, architecture)
        if policy is not None:
            numbers = architecture.numbers_of(policy)
            actor.load_numpy(unflatten(numbers, architecture.shapes(actor.sizes)))
        backend = JoblibBackend(experiment.workers)
        super().__init__(experiment, architecture, actor.sizes, backend)
        self._n_worlds = worlds_per_scenario(experiment)
        self._rounds = 0
        self._open()
        self._rollouts.warm_up(self._numbers)

    @property
    def done(self) -> int:
        """Rounds completed so far."""
        return self._rounds

    def advance(self, progress: ProgressLogger) -> str:
        """Run one round (record, fit), save the checkpoint, and return a line on the gain."""
        begin = time.perf_counter()
        exchanges = self._exchanges()
        wall = time.perf_counter() - begin
        shares = self._fit(exchanges)
        self._rounds += 1
        self._save()
        scalars = {f"share/{name}": share for name, share in shares.items()}
        scalars["speed/episodes_per_s"] = sum(self._n_worlds.values()) / wall
        scalars["speed/simulated_s_per_s"] = self._simulated_s / self.done / wall
        progress.log_scalars(self.done, scalars)
        gains = ", ".join(f"{name} {share:.0%}" for name, share in shares.items())
        return f"round {self.done}: gain per exchange as a share of the oracle's: {gains}"

    def _exchanges(self) -> dict[str, Exchanges]:
        """Record the exchanges of one round of new worlds, for each scenario."""
        experiment = self._experiment
        seeds = experiment.training_seeds(self.done * experiment.worlds, experiment.worlds)
        calls = [
            partial(
                record_exchanges,
                scenario,
                experiment.base_controller,
                self._numbers,
                seeds[: self._n_worlds[name]],
                experiment.physics,
            )
            for name, scenario in self._scenarios.items()
        ]
        recorded = run_in_order(self._rollouts.backend, operator.call, calls)
        return dict(zip(self._scenarios, recorded, strict=True))

    def _fit(self, exchanges: Mapping[str, Exchanges]) -> dict[str, float]:
        """Fit the network; return its error reduction as a share of the oracle's, per scenario."""
        experiment = self._experiment
        torch.set_num_threads(1)  # makes sums independent of the number of workers
        draws = torch.Generator().manual_seed(experiment.seed + self.done)
        gains = {name: each.gain(name) for name, each in exchanges.items()}
        left = 1.0 - self.done / experiment.budget
        optimiser = torch.optim.Adam(list(self._actor.arrays.values()), LEARNING_RATE * left)
        for _ in range(GRADIENT_STEPS):
            batches = {name: each.draw(draws) for name, each in exchanges.items()}
            errors = [each.error(self._actor) / gains[name] for name, each in batches.items()]
            loss = torch.stack(errors).mean()
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        return {name: each.share(self._actor, gains[name]) for name, each in exchanges.items()}

    @property
    def _numbers(self) -> Float32[Array, " numbers"]:
        shapes = self._architecture.shapes(self._sizes)
        return flatten(self._actor.to_numpy(), shapes).astype(np.float32)

    @property
    def _simulated_s(self) -> float:
        each = (self._n_worlds[k] * s.n_ticks * s.tick for k, s in self._scenarios.items())
        return self.done * sum(each)

    @property
    def _state(self) -> dict[str, Array]:
        return {"rounds": np.array(self.done), **self._actor.to_numpy()}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        self._rounds = int(arrays["rounds"])
        self._actor.load_numpy(arrays)
