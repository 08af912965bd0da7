"""E-pucks: body, sensors, radio, contacts, faults, and the tick of a world."""
