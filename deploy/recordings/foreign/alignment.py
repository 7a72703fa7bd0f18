"""Streams of their own rates, brought to common instants."""

from collections.abc import Sequence

import numpy as np

from deploy.errors import CommandError
from deploy.recordings.foreign.tracks import Track

Array = np.ndarray
MOST = 20_000_000  # instants


def common_grid(tracks: Sequence[Track], grid: str | float) -> Array:
    """Return the instants at which all streams are given, (G,) ns.

    Args:
        tracks: The streams.
        grid: ``fastest``: those of the stream of positions with the most samples; or a
            rate [Hz], from the first position to the last.

    Raises:
        CommandError: There is no position, or there are too many instants.
    """
    positions = [track for track in tracks if track.kind == "q" and len(track.times)]
    if not positions:
        raise CommandError("no joint position could be read; a recording needs a stream q")
    if grid == "fastest":
        return min(positions, key=lambda track: track.period or np.inf).times
    first = min(track.times[0] for track in positions)
    last = max(track.times[-1] for track in positions)
    count = int((last - first) * 1e-9 * float(grid)) + 1
    if count > MOST:
        span = f"{(last - first) * 1e-9:.6g} s at {grid:g} Hz"
        raise CommandError(f"{span} are {count} instants, more than {MOST}; is a time stamp wrong?")
    return first + np.rint(np.arange(count) * (1e9 / float(grid))).astype(np.int64)


def interpolate(track: Track, grid: Array, gap: float) -> tuple[Array, Array]:
    """Return a stream's values (G, w, …) at the instants of a grid, and where they are valid (G,).

    Between two samples a straight line; where these are more than ``gap`` periods of the
    stream apart, and before the first and after the last, 0.0 and invalid.
    """
    values = np.zeros((len(grid), *track.values.shape[1:]))
    if not len(track.times):
        return values, np.zeros(len(grid), dtype=bool)
    after = np.searchsorted(track.times, grid)  # of the first sample that is not earlier
    right = np.minimum(after, len(track.times) - 1)
    left = np.maximum(right - 1, 0)
    exact = track.times[right] == grid
    left = np.where(exact, right, left)
    span = track.times[right] - track.times[left]
    inside = (after < len(track.times)) & (exact | (after > 0))
    valid = inside & (span <= gap * track.period)
    share = np.where(span > 0, (grid - track.times[left]) / np.maximum(span, 1), 0.0)
    share = share.reshape(-1, *[1] * (track.values.ndim - 1))
    line = (1.0 - share) * track.values[left] + share * track.values[right]
    values[valid] = line[valid]
    return values, valid
