"""Robots that forage between a nest and a prey area (TR, ANTS)."""
