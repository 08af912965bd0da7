"""Training of learned layers (PPO, CMA-ES, DAgger), the bundled policies, the console script."""
