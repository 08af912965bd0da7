"""Controllers by name, with parameters: `ssgiff` or `ssgiff:beta=0.01,refractory=10`."""

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import ControllerRecipe
from swarm_forage_env.registry import CONTROLLERS


def find_controller(controller: str | ControllerRecipe) -> ControllerRecipe:
    """The recipe of a name, of a name with parameters (`ssgiff:beta=0.01`), or the given one.

    UnknownNameError for a name or a parameter that stands for nothing, ConfigError for a text
    of another form or a value that does not fit.
    """
    if not isinstance(controller, str):
        if not hasattr(controller, "build") or not hasattr(controller, "with_parameters"):
            raise ConfigError(f"controller={controller!r}: must be a name or a recipe")
        return controller
    name, parameters = parse_controller(controller)
    recipe: ControllerRecipe = CONTROLLERS[name]
    return recipe.with_parameters(parameters) if parameters else recipe


def parse_controller(text: str) -> tuple[str, dict[str, str]]:
    """The name and the parameters in `name:parameter=value,parameter=value`.

    >>> parse_controller("ssgiff:beta=0.01,refractory=10")
    ('ssgiff', {'beta': '0.01', 'refractory': '10'})
    """
    name, colon, rest = (part.strip() for part in text.partition(":"))
    parameters: dict[str, str] = {}
    for item in rest.split(",") if colon else ():
        parameter, equals, value = (part.strip() for part in item.partition("="))
        if not (parameter and equals and value):
            raise ConfigError(
                f"controller='{text}': '{item.strip()}' must be parameter=value,"
                " as in ssgiff:beta=0.01,refractory=10"
            )
        if parameter in parameters:
            raise ConfigError(f"controller='{text}': {parameter} is given twice")
        parameters[parameter] = value
    return name, parameters
