"""The robot's sensors: each turns the truth into readings, noise and all."""
