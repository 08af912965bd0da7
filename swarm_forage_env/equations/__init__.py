"""Compiled pure functions: an equation on scalars first, then the loop over robots."""
