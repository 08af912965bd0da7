"""The package of somebody else's is imported in a process of its own only."""

collect_ignore = ["second"]
