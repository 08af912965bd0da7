"""References: strategies that know the ground truth, to compare the others with.

Nothing outside this folder and the control loop may see the truth; no environment takes a
reference.
"""
