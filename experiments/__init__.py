"""The papers' experiments and the touch benchmark, as commands."""
