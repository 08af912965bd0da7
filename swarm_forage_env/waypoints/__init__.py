"""The waypoints task: robots visit goals, with home as their only landmark (BOIDS)."""
