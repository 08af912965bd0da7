"""Pictures of a world: scenes, still and moving, on a screen, in a file, or as arrays."""
