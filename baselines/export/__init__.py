"""Export of the controller of one robot as machine code: `swarm-forage export`."""
