"""What the contact detector learns from motions in which nothing touches the robot."""

from dataclasses import dataclass

import numpy as np

Array = np.ndarray
ROUNDS = 60  # after which the variances change by less than a percent


@dataclass(frozen=True, eq=False)
class ContactCalibration:
    """Floors of the variances and thresholds.

    ``floor``: (nv,) variance of each row of ``ContactRows`` beyond its sensor's noise.
    ``threshold``: (s,) of the sub-trees and ``body_threshold`` of the whole body, in
    standard deviations; ``samples``: of the motion.
    """

    floor: Array
    threshold: Array
    body_threshold: float
    samples: int


def likeliest_variances(moment: Array, fixed: Array, removal: Array, least: Array) -> Array:
    """Return the variances v >= least with which rows of covariance fixed + P v P^T are likeliest.

    The fixed-point iteration of Zhou, Hu, Qiao and Wheeler (MM algorithms for variance
    components models, 2019), in which the likelihood never falls.

    Args:
        moment: (a, a) mean of the squares and products of the rows.
        fixed: (a, a) covariance that is known.
        removal: P, (a, nv), from the readings to the rows.
        least: (nv,) variances of the readings, positive.
    """
    variances = least.copy()
    for _ in range(ROUNDS):
        seen = np.linalg.solve(fixed + (removal * variances) @ removal.T, removal)
        expected = (seen * removal).sum(axis=0)
        found = (seen * (moment @ seen)).sum(axis=0)
        ratio = np.divide(found, expected, out=np.zeros_like(found), where=expected > 0.0)
        variances = np.maximum(least, variances * np.sqrt(ratio))
    return variances
