"""Robots that visit waypoints, with home as their only landmark (BOIDS)."""
