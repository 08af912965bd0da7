"""Reproduction of papers: their claims and figures, each from its own experiments."""
