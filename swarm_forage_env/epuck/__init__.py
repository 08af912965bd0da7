"""The e-puck: its body, sensors, radio, contacts, faults, and the tick of a world full of them."""
