"""Benchmark of speed and memory against fixed budgets."""
