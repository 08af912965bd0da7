"""The command `export`: the controller of one robot as machine code."""

from pathlib import Path
from typing import Annotated, Literal

import typer
from typer import Argument, Option

from baselines.evaluation.common_options import (
    FileOption,
    SettingsOption,
    controller_names,
    scenario_names,
)


def export(
    controller: Annotated[
        str, Argument(help="Controller, with optional parameters.", autocompletion=controller_names)
    ],
    target: Annotated[
        Literal["cortex-m4", "cortex-a", "x86-64", "wasm32"],
        Option(help="Processor of the machine code; the e-puck 2 has a Cortex-M4."),
    ] = "cortex-m4",
    scenario: Annotated[
        str, Option(help="Scenario whose parameters the code has.", autocompletion=scenario_names)
    ] = "es1",
    settings: SettingsOption = None,
    argos: Annotated[
        bool,
        Option("--argos", help="Also write an experiment for ARGoS 3, with a controller in C++."),
    ] = False,
    out: Annotated[
        Path | None,
        FileOption(help="Folder to write the files to.", show_default="runs/export-<controller>"),
    ] = None,
) -> None:
    """Write the controller of one robot as machine code, with a header and an example for C.

    The example replays 1,000 ticks of a simulated robot (vectors.bin) and reports in how many of
    them commands and messages are the same, bit for bit. --argos adds experiment.argos, floor.png
    and argos_controller.cpp.
    """
    from baselines.evaluation.dataset import Dataset
    from baselines.evaluation.experiment_config import find_layered_controller, parse_settings
    from baselines.export.argos import check_for_argos, write_argos
    from baselines.export.files import export as write
    from baselines.export.robot import ExportedRobot
    from swarm_forage_env.errors import ConfigError
    from swarm_forage_env.scenarios import find_scenario

    layered = find_layered_controller(controller)
    exported = ExportedRobot(layered, find_scenario(scenario, parse_settings(settings or [])))
    folder = out or Path("runs") / f"export-{controller.replace(':', '-')}"
    if argos and target != "x86-64":
        raise ConfigError(
            f"--argos: ARGoS runs on a computer, not on {target}; add --target x86-64"
        )
    if argos:
        check_for_argos(exported)
    Dataset(folder).open()  # refuses what cannot be written, as evaluate does
    weight = write(exported, target, folder, argos)
    if argos:
        write_argos(exported, folder)
    typer.echo(
        f"{folder}: {controller} for {target}: {weight.code:,} bytes of code, {weight.data:,} of"
        f" numbers, {weight.ram:,} of RAM; see {folder / 'README.md'}"
    )
