"""Oracles: reference controllers that read the ground truth; no environment runs them."""
