"""Environments: the batch API `ArrayEnv`, and those for PettingZoo and Gymnasium on top of it."""
