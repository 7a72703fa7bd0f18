"""The page's colours of a probability."""

from collections.abc import Sequence

import numpy as np

Array = np.ndarray

UNLIKELY, LIKELY = np.array([96, 40, 130]), np.array([255, 70, 200])


def probability_colours(probabilities: Sequence[float] | Array) -> Array:
    """Return colours from dark violet (0) to bright pink (1), (m, 3) uint8."""
    weights = np.clip(probabilities, 0.0, 1.0)[:, None]
    return (UNLIKELY + weights * (LIKELY - UNLIKELY)).astype(np.uint8)
