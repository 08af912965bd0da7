"""The table of `swarm-forage bench --device cuda`."""

from typing import Any

from rich.console import Group
from rich.text import Text

from baselines.evaluation.fitting_table import FittingTable

STAGES = "decide", "tick", "observe"


def gpu_table(found: list[dict[str, Any]]) -> Group:
    """What was measured, a row for each number of worlds; a dash for what the driver tells not."""
    rows = [_cells(each) for each in found]
    columns = {heading: [Text(row[heading]) for row in rows] for heading in rows[0]}
    return Group(
        Text("Worlds on a GPU: kinematic, ssgikf; millions of robot-steps a second", style="bold"),
        FittingTable("worlds", [each["case"] for each in found], columns),
        Text(
            "Bytes are those of the records that the kernels are handed, each read or written"
            " once. Energy is in joules per million robot-steps. Learning: by the arrays of an"
            " environment whose motion is learned, without a network.",
            style="dim",
        ),
    )


def _cells(each: dict[str, Any]) -> dict[str, str]:
    """The cells of a row by their headings."""
    return {
        "GPU": _millions(each["gpu"]),
        "learning": _millions(each["environment"]),
        "CPU": _millions(each["cpu"]),
        "threads": str(each["threads"]),
        **{stage: _or_dash(each["shares"].get(stage), ".0%") for stage in STAGES},
        "bytes": f"{each['bytes_per_robot_step']:.0f}",
        "GB/s": _or_dash(each["bandwidth"], ".0f", 1e-9),
        "of card": _or_dash(each["share_of_card"], ".0%"),
        "J": _or_dash(each["joules_per_million"], ".3g"),
        "first [s]": f"{each['first_step_s']:.1f}",
    }


def _millions(speed: float) -> str:
    """A speed in millions a second, with three digits or all whole ones."""
    found = speed / 1e6
    return f"{found:,.0f}" if found >= 100.0 else f"{found:.3g}"


def _or_dash(number: float | None, form: str, scale: float = 1.0) -> str:
    return "-" if number is None else format(number * scale, form)
