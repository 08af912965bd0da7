"""Evaluation: episodes, kept as a dataset, told as tables and plots with intervals."""
