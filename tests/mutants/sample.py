"""Drop the mutants that a filter left out of a session, and keep a sample of the others.

python tests/mutants/sample.py SESSION SIZE SEED   # SIZE 0: all of them
"""

import random
import sqlite3
import sys


def sample(session, size, seed):
    """How many mutants there are, and how many of them, drawn by the seed, were kept."""
    with sqlite3.connect(session) as kept:
        skipped = {job for (job,) in kept.execute("select job_id from work_results")}
        specs = kept.execute(
            "select job_id from mutation_specs"
            " order by module_path, start_pos_row, start_pos_col, operator_name, occurrence"
        ).fetchall()
        there = [job for (job,) in specs if job not in skipped]
        drawn = set(random.Random(seed).sample(there, min(size or len(there), len(there))))
        dropped = [(job,) for (job,) in specs if job not in drawn]
        for table in ("work_results", "mutation_specs", "work_items"):
            kept.executemany(f"delete from {table} where job_id = ?", dropped)
    return len(there), len(drawn)


if __name__ == "__main__":
    there, drawn = sample(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
    sys.stdout.write(f"{drawn} of {there} mutants\n")
