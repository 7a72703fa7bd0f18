"""Median, tail and worst of measured values."""

from collections.abc import Iterable, Sequence

QUANTILES = {"p50": 0.5, "p99": 0.99}


def distribution(values: Iterable[float], prefix: str = "") -> dict[str, float | None]:
    """Return ``p50``, ``p99`` and ``max`` of the values; None where there are none."""
    ordered = sorted(values)
    found = {name: quantile(ordered, share) for name, share in QUANTILES.items()}
    found["max"] = ordered[-1] if ordered else None
    return {prefix + name: value for name, value in found.items()}


def quantile(ordered: Sequence[float], share: float) -> float | None:
    """Return the value that a share of the sorted values does not exceed."""
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)] if ordered else None
