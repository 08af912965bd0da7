"""Oracles: references that know the ground truth, to compare the other controllers with.

No environment runs one of them.
"""
