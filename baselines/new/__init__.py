"""The command `new`: a small package with a part of one's own, from templates."""
