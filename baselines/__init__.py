"""The hand-written controllers. They see a robot's interface only, never the ground truth."""
