"""Hand-written controllers. They read the interface of a robot only, never the ground truth."""
