"""Keep a sample of the mutants of a session, drawn by a fixed seed, and drop the others."""

import random
import sqlite3
import sys


def sample(session, size):
    """Drop all mutants of a session that have not been tried, but so many."""
    with sqlite3.connect(session) as kept:
        tried = {job for (job,) in kept.execute("select job_id from work_results")}
        specs = kept.execute(
            "select job_id from mutation_specs"
            " order by module_path, start_pos_row, start_pos_col, operator_name, occurrence"
        )
        left = [job for (job,) in specs if job not in tried]
        drawn = set(random.Random(1).sample(left, min(size, len(left))))
        dropped = [(job,) for job in left if job not in drawn]
        kept.executemany("delete from mutation_specs where job_id = ?", dropped)
        kept.executemany("delete from work_items where job_id = ?", dropped)
    return len(drawn)


if __name__ == "__main__":
    sys.stdout.write(f"{sample(sys.argv[1], int(sys.argv[2]))} mutants\n")
