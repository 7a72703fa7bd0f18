"""What laboratories know of a force/torque sensor beyond its offset.

reading = S raw - c (T - T0): a secondary matrix that corrects the maker's calibration, and
coefficients of temperature. The offset is the tare's, and is taken off later.
"""

import numpy as np

Array = np.ndarray


class FtCalibration:
    """Corrects the readings of k sensors, before anybody else sees them.

    Args:
        maps: Secondary matrices S, (k, 6, 6); whatever follows in the same axes may be
            multiplied in.
        slopes: Coefficients c, (k, 6) N/K and N m/K, mapped likewise.
        references: Temperatures T0 at which the matrices were found, (k,) degC.
        hold: How long a sensor's last temperature serves when no new one comes [s].
    """

    def __init__(self, maps: Array, slopes: Array, references: Array, hold: float):
        self._maps, self._slopes, self._references = maps, slopes, references
        self._hold = round(hold * 1e9)
        self._needs = slopes.any(axis=1)
        self._compensates = bool(self._needs.any())
        self._temperature = references.copy()
        self._since = np.zeros(len(references), dtype=np.int64)  # ns, of the last temperature
        self._known = np.zeros(len(references), dtype=bool)

    def apply(self, ft: Array, temperature: Array | None, good: Array, stamp: int) -> Array:
        """Return the corrected readings, (k, 6) N and N m.

        Args:
            ft: Readings, (k, 6).
            temperature: (k,) degC, or None when none came.
            good: Which temperatures are valid, (k,) bool; non-finite ones never are.
            stamp: Time of the readings [ns].
        """
        corrected = np.matvec(self._maps, ft)
        if self._compensates:
            if temperature is not None:
                self._take(temperature, good, stamp)
            warmer = self._temperature - self._references
            corrected -= self._slopes * warmer[:, None]
        return corrected

    def lacking(self, stamp: int) -> Array | None:
        """Return which sensors have coefficients and no temperature that still serves, (k,).

        Their readings may be wrong by any drift, so nobody should use them. None: no sensor
        has coefficients.
        """
        if not self._compensates:
            return None
        age = stamp - self._since
        return self._needs & ~(self._known & (age >= 0) & (age <= self._hold))

    def _take(self, temperature: Array, good: Array, stamp: int) -> None:
        new = good & np.isfinite(temperature)
        self._temperature = np.where(new, temperature, self._temperature)
        self._since = np.where(new, stamp, self._since)
        self._known |= new
