"""Compiled pure functions on scalars: geometry, drive, sensors, radio, obstacles, random draws."""
