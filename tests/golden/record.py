"""Write down what the swarm does, or compare it with what was written down.

    python -m tests.golden.record [--check] [--only SUBSTRING]

`make golden` writes `tests/golden/data/` anew. For every case (see `cases`) that holds, at each
tick, 16 bits of a checksum of each quantity (see `readout`), and the whole numbers of the end:
enough to tell what differs first and when, in a few megabytes.

Data is of one kind of machine: the engine `rigid` and what is drawn in NumPy call its libm.
"""

import platform
import sys
from argparse import ArgumentParser
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

import numpy as np

from swarm_forage_env.arrays import Array
from tests.golden.cases import Case, Results, all_cases
from tests.golden.readout import Readout

DATA = Path(__file__).parent / "data"
KINDS = ("foraging", "waypoints", "environments")
MACHINE = f"{platform.system()} {platform.machine()}"


@dataclass(frozen=True)
class Recording:
    """What a case did: checksums by quantity, one for the reset and for each tick; the results."""

    checksums: dict[str, Array]
    results: Results


def record(case: Case, length: int | None = None) -> Recording:
    """Play a case, or the first ticks of it."""
    checksums: dict[str, list[int]] = {}

    def take(readout: Readout) -> None:
        for quantity, plain in readout.items():
            checksums.setdefault(quantity, []).append(crc32(plain) >> 16)

    results = case.play(case.length if length is None else length, take)
    return Recording({name: np.array(row, "<u2") for name, row in checksums.items()}, results)


def differences(golden: Recording, found: Recording) -> list[str]:
    """Which quantity differs from the golden recording, from which tick on; first ones first.

    The results of a recording that is shorter than the golden one are not compared.
    """
    if golden.checksums.keys() != found.checksums.keys():
        return [f"quantities {[*found.checksums]} instead of {[*golden.checksums]}"]
    lines, length = [], min(len(row) for row in found.checksums.values())
    for quantity, row in found.checksums.items():
        other = np.flatnonzero(row != golden.checksums[quantity][:length])
        if len(other):
            lines.append((other[0], f"{quantity} first differ at tick {other[0]}"))
    lines_of_cases = [line for _, line in sorted(lines)]
    if length == min(len(row) for row in golden.checksums.values()):
        lines_of_cases += [
            f"{name} in the end {found.results.get(name)} instead of {numbers}"
            for name, numbers in golden.results.items()
            if found.results.get(name) != numbers
        ]
    return lines_of_cases


def load() -> dict[str, Recording]:
    """The golden recordings by name of the case."""
    found: dict[str, Recording] = {}
    for file in DATA.glob("*.npz"):
        with np.load(file) as data:
            for key in data.files:
                name, _, part = key.rpartition("#")
                into = found.setdefault(name, Recording({}, {}))
                if part.startswith("end "):
                    into.results[part.removeprefix("end ")] = data[key].tolist()
                else:
                    names = part.split(" ")
                    into.checksums.update(zip(names, data[key], strict=True))
    return found


def save(recordings: dict[str, Recording], cases: dict[str, Case]) -> None:
    """Write the recordings of these cases, a file for each kind; those of other cases go."""
    for kind in KINDS:
        arrays: dict[str, Array] = {}
        kept = [name for name in sorted(recordings) if name in cases and cases[name].kind == kind]
        for name in kept:
            made = recordings[name]
            arrays[f"{name}#{' '.join(made.checksums)}"] = np.stack([*made.checksums.values()])
            for result, numbers in made.results.items():
                arrays[f"{name}#end {result}"] = np.array(numbers, "<i8")
        np.savez_compressed(DATA / f"{kind}.npz", **arrays)
    (DATA / "machine.txt").write_text(f"{MACHINE}\n", encoding="utf-8")


def main() -> int:
    """The command; 1 if something differs."""
    parser = ArgumentParser("python -m tests.golden.record", description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare, and write nothing")
    parser.add_argument("--only", default="", help="cases with this in their name")
    options = parser.parse_args()
    cases, golden, different = all_cases(), load(), 0
    chosen = [case for name, case in cases.items() if options.only in name]
    for case in chosen:
        found = record(case)
        if options.check:
            lines = differences(golden.get(case.name, Recording({}, {})), found)
            different += bool(lines)
            sys.stdout.write("".join(f"{case.name}: {line}\n" for line in lines))
        golden[case.name] = found
    if not options.check:
        save(golden, cases)
    sys.stdout.write(f"{len(chosen)} cases, {different} different\n")
    return int(different > 0)


if __name__ == "__main__":
    sys.exit(main())
