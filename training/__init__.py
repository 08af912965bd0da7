"""Learning: networks in the place of a layer; and the console script."""
