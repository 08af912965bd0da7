"""Hand-written layers driven from outside: from rows of records, as a rule in NumPy is."""

import numpy as np

from swarm_forage_env.compiler import bind
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.random_streams import streams
from swarm_forage_env.record import one_record, rows
from swarm_forage_env.waypoints.records import Readings


def steer_4(inputs, memory, numbers):
    """Steer every robot. Free name: steer."""
    situations, readings, heard, wheels = inputs
    for i in range(wheels.shape[0]):
        steer(situations[i], readings[i], heard[i], wheels[i], memory[i], numbers[0])


def steer_3(inputs, memory, numbers):
    """Steer every robot that hears no messages. Free name: steer."""
    situations, readings, command = inputs
    for i in range(command.shape[0]):
        steer(situations[i], readings[i], command[i], memory[i], numbers[0])


class OutsideMotion:
    """A compiled motion that is called with records, a row for each robot, and remembers."""

    def __init__(self, layer, scenario, seeds):
        self._layer, self._n_robots = layer, scenario.task.n_robots
        self._numbers = one_record(layer.numbers)
        self._memory = layer.memory.array((len(seeds), self._n_robots))
        for world, seed in enumerate(seeds):
            self.reset(world, seed)

    def __call__(self, *inputs):
        """The next command of every robot; the last input is the last one."""
        template = steer_4 if len(inputs) == 4 else steer_3
        command = inputs[-1].copy()
        steer_all = bind(template, {"steer": self._layer.steer})
        steer_all((*inputs[:-1], command), self._memory.reshape(-1), self._numbers)
        return command

    def reset(self, world, seed):
        """Forget everything about one world, and draw from this seed from now on."""
        memory = self._memory[world]
        self._layer.memory.restart(memory)
        if "stream" in self._layer.memory.fields:
            memory["stream"][:, 0] = streams([seed], self._n_robots, self._layer.noise)


class OutsideMotionPart:
    """A part whose motion is a compiled one driven from outside."""

    def __init__(self, part, tasks=("foraging",)):
        self._part, self.tasks = part, tasks

    def start(self, scenario, seeds):
        """The running motion."""
        return OutsideMotion(self._part.layer(scenario), scenario, seeds)


class SGIKFInNumPy:
    """The weighting `sgikf` as a rule in NumPy."""

    heard_p_share = 0.0

    def __call__(self, exchange):
        """The share of the own path in both."""
        total = exchange.own_p + exchange.heard_p
        half = np.full_like(total, 0.5)
        return np.divide(exchange.own_p, total, out=half, where=total > 0.0)


def weigh(layer, exchange):
    """The weights that a compiled rule gives corrections, a row for each robot."""
    g, numbers = np.zeros((len(exchange), 1), np.float32), one_record(layer.all_numbers)
    bind(weigh_1, {"gain": layer.gain})(exchange, numbers, g)
    return g


def weigh_1(exchanges, numbers, g):
    """Weigh every correction. Free name: gain."""
    for i in range(g.shape[0]):
        if exchanges[i].is_valid:
            g[i, 0] = gain(exchanges[i], 0, numbers[0])


def shown_records(layout, observations):
    """The records that observations in SI units show, a row for each robot, by name.

    Fields that are not observed have their first value, but how many messages were heard.
    """
    matrix, records = np.stack(list(observations.values())), {}
    for path, span in layout._spans():
        shape, name = path.shape(layout.sizes), path.source.rpartition(".")[2]
        if name not in records:
            records[name] = rows(path.record.array((len(matrix),), **layout.sizes))
        records[name][path.name] = matrix[:, span].reshape(len(matrix), *shape)
    if "heard" in records:
        records["heard"].n = records["heard"].is_valid.sum(axis=1)
    return records


def motion_inputs(seen, commanded="wheels"):
    """What the motion layer sees, of the records that an observation shows."""
    heard = [seen["heard"]] if "heard" in seen else []
    readings = seen.get("readings", Readings.array((len(seen["situation"]),)))
    return (seen["situation"], readings, *heard, seen["command"][commanded])


def exchanges(rows, **columns):
    """Exchanges about areas that both robots know, with these columns."""
    found = Exchange.array((rows,)).view(np.recarray)
    found.is_valid = found.own_known = found.heard_known = 1.0
    for name, column in columns.items():
        found[name] = column
    return found
