"""The papers: their numbers and figures, and what they leave open."""
