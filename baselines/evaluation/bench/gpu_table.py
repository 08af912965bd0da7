"""The table of `swarm-forage bench --device cuda`."""

from typing import Any

from rich.table import Table

STAGES = "decide", "tick", "observe"


def gpu_table(found: list[dict[str, Any]]) -> Table:
    """What was measured, a row for each number of worlds; a dash for what the driver tells not."""
    table = Table(
        title="Worlds on a GPU: kinematic, ssgikf; millions of robot-steps per second",
        caption="Bytes are those of the records that the kernels are handed, each read or written"
        " once. Energy is in joules per million robot-steps.",
    )
    memory = "bytes", "GB/s", "of card"
    for column in ("worlds", "GPU", "CPU", "threads", *STAGES, *memory, "J", "first [s]"):
        table.add_column(column, justify="right")
    for each in found:
        shares = (_or_dash(each["shares"].get(stage), ".0%") for stage in STAGES)
        table.add_row(
            each["case"],
            f"{each['gpu'] / 1e6:.3g}",
            f"{each['cpu'] / 1e6:.3g}",
            str(each["threads"]),
            *shares,
            f"{each['bytes_per_robot_step']:.0f}",
            _or_dash(each["bandwidth"], ".0f", 1e-9),
            _or_dash(each["share_of_card"], ".0%"),
            _or_dash(each["joules_per_million"], ".3g"),
            f"{each['first_step_s']:.1f}",
        )
    return table


def _or_dash(number: float | None, form: str, scale: float = 1.0) -> str:
    return "-" if number is None else format(number * scale, form)
