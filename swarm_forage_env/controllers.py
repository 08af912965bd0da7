"""Controllers by name, with parameters: `ssgiff` or `ssgiff:beta=0.01,refractory=10`."""

import re
from collections.abc import Mapping, Sequence
from os.path import isfile
from typing import Any

from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.interface import Controller, is_privileged
from swarm_forage_env.mixed import MixedController
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.registry import CONTROLLERS, JOINT, POLICIES, REFERENCES, SCENARIOS, left_out
from swarm_forage_env.task import task_of

OneController = str | Controller
"""A name, a name with parameters, or a controller."""

Controllers = OneController | Sequence[OneController] | Mapping[Any, OneController]
"""One controller for all robots, a list with one for each, or a mapping by robot."""

OTHERS = "*"
"""Key of a mapping for all robots that the mapping does not name."""


def find_controller(controller: str | Controller, references: bool = False) -> Controller:
    """Return the controller of a name, with parameters if wanted (`ssgiff:beta=0.01`).

    A name may be a composition of layers, `social_odometry+sgiff+subsumption:beta=0.01`, or a kind
    of policy and its file, `sb3:model.zip`. UnknownNameError for an unknown name or parameter;
    ConfigError for a text of another form, for a value that does not fit, and for an oracle unless
    `references` is true.

    >>> find_controller("ssgiff:beta=0.01").name
    'ssgiff'

    Args:
        controller: A name, with parameters if wanted, or a controller.
        references: Accept oracles, which know the ground truth.
    """
    if not isinstance(controller, str):
        if not isinstance(controller, Controller):
            raise ConfigError(f"controller={controller!r}: must be a name or a controller")
        return _admitted(controller, references)
    name = controller.partition(":")[0].strip()
    first = getattr(POLICIES[name], "main_parameter", None) if name in POLICIES else None
    name, parameters = parse_controller(controller, first=first)
    admitted = _admitted(_named(name, references), references)
    return admitted.with_parameters(parameters) if parameters else admitted


def find_controllers(controller: Controllers | None, scenario: BaseScenario) -> Controller:
    """Return the controller of a swarm, given one for all robots, a list or a mapping.

    A list has one entry for each robot. The keys of a mapping are names (`epuck_0`) or indices of
    robots; robots that it does not name get its entry `*`, or else the default of the task. Entries
    are arguments of `find_controller`; oracles are refused.

    ConfigError for a list of another length, UnknownNameError for an unknown robot.

    Args:
        controller: One controller, a list with one for each robot, or a mapping; None: the task's
            default.
        scenario: The scenario of the swarm; it gives the number of robots.
    """
    task = task_of(scenario)
    if isinstance(controller, Mapping):
        named = _by_number(controller, task.agents(scenario.task.n_robots))
        others = controller.get(OTHERS, task.controller)
        wanted = [named.get(robot, others) for robot in range(scenario.task.n_robots)]
    elif isinstance(controller, Sequence) and not isinstance(controller, str):
        wanted = list(controller)
    else:
        return find_controller(task.controller if controller is None else controller)
    keys = [each if isinstance(each, str) else id(each) for each in wanted]
    distinct = dict(zip(keys, wanted, strict=True))
    controllers = {key: find_controller(each) for key, each in distinct.items()}
    members = [controllers[key] for key in keys]
    mixed = MixedController(tuple(members))
    mixed.check_supports(scenario)
    return members[0] if all(each == members[0] for each in members) else mixed


def robot_number(robot: object, agents: Sequence[str]) -> int:
    """Return the index of a robot, given its index or name; UnknownNameError if unknown."""
    number: Any = agents.index(robot) if robot in agents else robot
    if isinstance(number, bool) or number not in range(len(agents)):
        raise UnknownNameError("robot", str(robot), agents, f"indices: 0 to {len(agents) - 1}")
    return int(number)


def _by_number(
    controllers: Mapping[Any, OneController], agents: Sequence[str]
) -> dict[int, OneController]:
    numbered: dict[int, OneController] = {}
    for key, controller in controllers.items():
        if key == OTHERS:
            continue
        robot = robot_number(key, agents)
        if robot in numbered:
            raise ConfigError(f"controller: robot {robot} is given twice, by name and by number")
        numbered[robot] = controller
    return numbered


def _named(name: str, references: bool) -> Controller:
    registry = next((each for each in (CONTROLLERS, POLICIES, REFERENCES) if name in each), None)
    if registry is None:
        if name in SCENARIOS:
            raise ConfigError(f"no controller named {name!r}: it is a scenario; at most one is run")
        known = {*CONTROLLERS, *POLICIES, *(REFERENCES if references else ())}
        layers, note = CONTROLLERS.elements, left_out()
        if any(name in each for each in layers):
            kinds = JOINT.join(each.kind for each in layers)
            note = f"it is a layer, and three make a controller: {kinds}"
        raise UnknownNameError("controller", name, known, note)
    controller: Controller = registry[name]
    return controller


def _admitted(controller: Controller, references: bool) -> Controller:
    if is_privileged(controller) and not references:
        raise ConfigError(
            f"controller '{controller.name}' is a reference that knows the ground truth: it can be"
            " evaluated (swarm-forage evaluate), but no environment runs it"
        )
    return controller


PARAMETER = re.compile(r"\s*[A-Za-z_][\w.]*\s*=")
"""Pattern of the beginning of `parameter=value`."""

LIST = re.compile(PARAMETER.pattern + r"\s*\[")
"""Pattern of the beginning of a parameter whose value is a list in JSON."""


def parse_controller(
    text: str,
    kind: str = "controller",
    example: str = "ssgiff:beta=0.01,refractory=10",
    first: str | None = None,
) -> tuple[str, dict[str, str]]:
    """Return the name and the parameters of `name:parameter=value,parameter=value`.

    Scenarios have the same syntax; `kind` and `example` appear in error messages. A first value
    without a parameter name is that of the parameter `first`: the path of a file. If there is no
    such file, it extends to the next `,parameter=`, and begins with text that is no `parameter=`.

    >>> parse_controller("ssgiff:beta=0.01,refractory=10")
    ('ssgiff', {'beta': '0.01', 'refractory': '10'})
    >>> parse_controller("sb3:model.zip,stack=2", first="file")
    ('sb3', {'file': 'model.zip', 'stack': '2'})
    >>> parse_controller("es1:arena.corners=[[0, 0], [1, 0]],tick=0.1")
    ('es1', {'arena.corners': '[[0, 0], [1, 0]]', 'tick': '0.1'})
    >>> parse_controller("sb3:runs/lr=0.1,b/m.zip,stack=2", first="file")
    ('sb3', {'file': 'runs/lr=0.1,b/m.zip', 'stack': '2'})
    """
    name, colon, rest = (part.strip() for part in text.partition(":"))
    parameters: dict[str, str] = {}
    for number, item in enumerate(_items(rest, first) if rest or (colon and not first) else ()):
        parameter, equals, value = (part.strip() for part in item.partition("="))
        if number == 0 and first and item.strip() and not PARAMETER.match(item):
            parameter, equals, value = first, "=", item.strip()
        if not (parameter and equals and value):
            raise ConfigError(
                f"{kind}='{text}': '{item.strip()}' must be parameter=value, as in {example}"
            )
        if parameter in parameters:
            raise ConfigError(f"{kind}='{text}': {parameter} is given twice")
        parameters[parameter] = value
    return name, parameters


def _items(rest: str, first: str | None) -> list[str]:
    """Split at commas, except for those in lists, in the path of a file, and in that of `first`."""
    items: list[str] = []
    parts: list[str] = []
    for part in rest.split(","):
        if parts and LIST.match(parts[-1]) and parts[-1].count("[") > parts[-1].count("]"):
            parts[-1] += f",{part}"
        else:
            parts.append(part)
    while parts:
        for n in range(len(parts), 0, -1):
            text = ",".join(parts[:n]).strip()
            is_first = bool(first and not items and isfile(text))
            is_named = PARAMETER.match(text) and isfile(text.partition("=")[2].strip())
            if n == 1 or is_first or is_named:
                break
        items.append(f"{first}={text}" if is_first else text)
        del parts[:n]
    while first and len(items) > 1 and not PARAMETER.match(items[1]):
        items[:2] = [",".join(items[:2])]
    return items
