"""Evaluation: run episodes, keep them as a Parquet dataset, and report them with intervals."""
