"""Help of commands that names the value of an option as manuals do: `--seed N`, not `<int>`."""

from collections.abc import Iterable
from functools import partial

from typer import Context, Typer
from typer.core import TyperArgument, TyperCommand, TyperGroup, TyperOption

VALUES = {"int": "N", "int range": "N", "float": "X", "str": "NAME", "Path": "PATH", "bool": ""}
"""What stands for a value of each type; a switch has none."""


def value_in_help(parameter: TyperArgument | TyperOption, ctx: Context) -> str:
    """What help shows beside the name of an argument or option: its choices, or what it takes."""
    is_option = isinstance(parameter, TyperOption)
    if is_option and parameter.metavar is not None:
        return parameter.metavar
    shown = parameter.display_type(ctx)
    kind = shown.strip("<>").removeprefix("list[").removesuffix("]")
    if kind not in VALUES:
        return shown
    return VALUES[kind] if is_option else ""


def _name_values(parameters: Iterable[object]) -> None:
    for each in parameters:
        if isinstance(each, TyperArgument | TyperOption):
            each.display_type_rich = partial(value_in_help, each)  # type: ignore[method-assign]


class HelpfulCommand(TyperCommand):
    """A command with such a help."""

    def format_help(self, ctx: Context, formatter: object) -> None:  # type: ignore[override]
        """Write the help."""
        _name_values(self.get_params(ctx))
        super().format_help(ctx, formatter)  # type: ignore[arg-type]


class HelpfulGroup(TyperGroup):
    """A group of commands with such a help."""

    def format_help(self, ctx: Context, formatter: object) -> None:  # type: ignore[override]
        """Write the help."""
        _name_values(self.get_params(ctx))
        super().format_help(ctx, formatter)  # type: ignore[arg-type]


def name_values(commands: Typer) -> None:
    """Let every command of an application, and of its groups, have such a help."""
    commands.info.cls = HelpfulGroup
    for each in commands.registered_commands:
        each.cls = HelpfulCommand
    for group in commands.registered_groups:
        group.cls = HelpfulGroup
        if group.typer_instance is not None:
            name_values(group.typer_instance)
