"""Controllers of one robot as machine code: `swarm-forage export`."""
