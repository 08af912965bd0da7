"""Budgets of the benchmark, goals of worlds on a GPU, and tables of the results."""

from rich.console import Group, RenderableType
from rich.table import Column, Table
from rich.text import Text

from baselines.evaluation.bench.cases import Measured
from baselines.evaluation.bench.speed import SHARES
from baselines.evaluation.tables import FittingTable


def report(measured: Measured) -> Group:
    """Return the tables of speeds, stages and budgets, one below the other."""
    machine = ", ".join(f"{name} {value}" for name, value in measured["machine"].items())
    hurried = " (quick: less exact)" if measured["quick"] else ""
    return Group(
        Text(f"Million robot-steps per second, one core{hurried}", style="bold"),
        _speeds(measured), Text(
            "arrays, dicts: through ArrayEnv, or through PettingZoo's dictionaries; es3 spread,"
                " x 10, x 100: robots start all over an arena of 1, 10 or 100 times the size.",
            "dim",
        ),
        Text("\nShare of a tick [%]", style="bold"),
        _stages(measured),
        Text("\nBudgets", style="bold"),
        _budgets(measured["budgets"]),
        Text(f"Peak memory of this process {measured['peak_memory_mb']:.0f} MB; {machine}.", "dim"),
    )  # fmt: skip


def _speeds(measured: Measured) -> Table:
    table = _table("", "robots", "rigid", "kinematic", "bare pymunk", "rigid tick : bare")
    for row in measured["speeds"]:
        engines = [f"{row[name] / MILLION:.3f}" for name in ("rigid", "kinematic", "bare_pymunk")]
        table.add_row(row["case"], f"{row['rows']:,}", *engines, f"{row['rigid_over_bare']:.2f}")
    return table


def _stages(measured: Measured) -> Table:
    table = _table("", "engine", *SHARES)
    for row in measured["stages"]:
        shares = (f"{100.0 * row['shares'][stage]:.0f}" for stage in SHARES)
        table.add_row(row["case"], row["physics"], *shares)
    return table


def _budgets(rows: list[Measured]) -> Table:
    """Return a table with a row for each result of `check` or `goals_of`."""
    table = _table("", "measured", "budget", "")
    for row in rows:
        missed = abs(row["measured"] / row["budget"] - 1.0)
        verdict = Text("met", "green") if row["is_met"] else Text(f"missed by {missed:.0%}", "red")
        unit = f" {row['unit']}" if row["unit"] else ""
        numbers = f"{row['measured']:.3g}{unit}", f"{row['budget']:g}{unit}"
        table.add_row(row["what"], *numbers, verdict)
    return table


def _table(first: str, *others: str) -> Table:
    columns = (Column(heading, justify="right") for heading in others)
    return Table(first, *columns, box=None, padding=(0, 1, 0, 0))


MILLION = 1e6

SPEEDS = {
    "es1 x 30": {"kinematic": 4.0, "rigid": 1.2},
    "es3": {"kinematic": 3.0, "rigid": 1.0},
    "es1, ten ticks a call": {"kinematic": 2.5, "rigid": 0.4},
    "es1 x 64, arrays": {"kinematic": 4.0, "rigid": 1.0},
    "es1, dicts": {"kinematic": 0.2, "rigid": 0.15},
}
"""Minimum robot-steps per second of each case under each engine [10^6 / s]."""

GAIN_PER_THREAD = 0.9  # minimum speed-up per thread: 1.8 with two

COST_RATIO = 1.5
"""Maximum ratio of the time per robot among 10,000 to that among 100, at the same density."""

START_UP = {  # what is started, and its maximum time [s]
    "import": ("import swarm_forage_env", 0.3),
    "first_run": ("first run, which compiles", 30.0),
    "help": ("swarm-forage --help", 1.0),
    "list": ("swarm-forage list", 1.0),
}

GROWTH = 1.0  # maximum growth of peak memory in a long run [MB]: that of the allocator


def check(measured: Measured) -> list[Measured]:
    """Return every budget with its measured value and verdict, as dictionaries."""
    speeds = {row["case"]: row for row in measured["speeds"]}
    least = [
        (f"{case}, {engine}", speeds[case][engine] / MILLION, budget, "M/s")
        for case, budgets in SPEEDS.items()
        for engine, budget in budgets.items()
    ]
    for row in measured["threads"]:
        name = f"{row['threads']} threads : 1, {row['physics']}"
        least.append((name, row["gain"], GAIN_PER_THREAD * row["threads"], ""))
    most = []
    for engine in ("kinematic", "rigid"):
        ratio = speeds["es3 spread"][engine] / speeds["es3 x 100"][engine]
        most.append((f"cost of a robot, 10,000 : 100, {engine}", ratio, COST_RATIO, ""))
    for name, seconds in measured["start_up_s"].items():
        if name in START_UP:
            words, budget = START_UP[name]
            most.append((words, seconds, budget, "s"))
    memory = measured["memory"]
    most.append((f"memory growth, {memory['ticks']:,} ticks", memory["growth_mb"], GROWTH, "MB"))
    return _verdicts(least, most)


Budget = tuple[str, float, float, str]  # name, measured value, budget and unit


def _verdicts(least: list[Budget], most: list[Budget]) -> list[Measured]:
    """Return the minimum and the maximum budgets, each with whether it is met."""
    both = [(*each, each[1] >= each[2]) for each in least]
    both += [(*each, each[1] <= each[2]) for each in most]
    names = "what", "measured", "budget", "unit", "is_met"
    return [dict(zip(names, each, strict=True)) for each in both]


GPU_SPEEDS = {
    "gpu": ("GPU", {"es1 x 100": 60.0, "es1 x 1000": 250.0, "es1 x 10000": 350.0}),
    "environment": ("learning", {"es1 x 1000": 150.0, "es1 x 10000": 200.0}),
}
"""Minimum robot-steps per second on an H200 [10^6 / s]: column of the table, and goal by case."""

GPU_SECONDS = {
    "first_step_s": ("first step of a second start", {"es1 x 1": 3.0}),
    "made_s": ("made and reset", {"es1 x 100000": 2.0}),
}
"""Maximum times on an H200 [s]: what is timed, and goal by case."""

GPU_STAGES = "decide", "tick", "observe"


def gpu_table(measured: list[Measured]) -> Group:
    """Return a table with a row for each case; a dash for what the driver does not report."""
    rows = [_cells(each) for each in measured]
    columns = {heading: [Text(row[heading]) for row in rows] for heading in rows[0]}
    parts: list[RenderableType] = [
        Text("Worlds on a GPU: kinematic, ssgikf; millions of robot-steps a second", style="bold"),
        FittingTable("worlds", [each["case"] for each in measured], columns),
        Text(
            "Bytes: size of the records that the kernels read or write, each once. Energy:"
            " joules per million robot-steps. Learning: arrays of an environment whose motion is"
            " learned, without a network. VMAS: its navigation task with 8 rays, collisions and"
            " 10 agents, if installed.",
            style="dim",
        ),
    ]
    if goals := goals_of(measured):
        parts += [Text("\nGoals, of an H200", style="bold"), _budgets(goals)]
    return Group(*parts)


def goals_of(measured: list[Measured]) -> list[Measured]:
    """Return every goal of the measured cases, with its measured value and verdict."""
    by_case = {each["case"]: each for each in measured}
    least, most = (
        [
            (f"{case}: {words}", by_case[case][key] / unit, goal, name)
            for key, (words, goals) in each.items()
            for case, goal in goals.items()
            if case in by_case
        ]
        for each, unit, name in ((GPU_SPEEDS, MILLION, "M/s"), (GPU_SECONDS, 1.0, "s"))
    )
    return _verdicts(least, most)


def _cells(each: Measured) -> dict[str, str]:
    return {
        "GPU": _millions(each["gpu"]),
        "learning": _millions(each["environment"]),
        "VMAS": _or_dash(each["vmas"], ".3g", 1e-6),
        "CPU": _millions(each["cpu"]),
        "threads": str(each["threads"]),
        **{stage: _or_dash(each["shares"].get(stage), ".0%") for stage in GPU_STAGES},
        "bytes": f"{each['bytes_per_robot_step']:.0f}",
        "GB/s": _or_dash(each["bandwidth"], ".0f", 1e-9),
        "of card": _or_dash(each["share_of_card"], ".0%"),
        "J": _or_dash(each["joules_per_million"], ".3g"),
        "first [s]": f"{each['first_step_s']:.1f}",
    }


def _millions(speed: float) -> str:
    millions = speed / 1e6
    return f"{millions:,.0f}" if millions >= 100.0 else f"{millions:.3g}"


def _or_dash(number: float | None, form: str, scale: float = 1.0) -> str:
    return "-" if number is None else format(number * scale, form)
