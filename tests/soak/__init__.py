"""A long run of everything, with kills at random: ``python -m tests.soak --hours 1``."""
