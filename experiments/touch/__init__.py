"""The touch benchmark: seeded pushes and contact-free motion, and what the detector says."""

from experiments.touch.benchmark import run

__all__ = ["run"]
