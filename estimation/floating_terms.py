"""Momenta of a floating-base robot and their known rates, by matrix-vector products.

R forms the matrices H_fb, dH_fb/dt and C_fb of its eqs. (9) and (13). Its residuals need
only their products with vectors, which follow from the whole robot's mass matrix M,
Coriolis matrix C (dM/dt = C + C^T) and one factorisation of the 6x6 base block.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import get_lapack_funcs

Array = np.ndarray
_potrf, _potrs = get_lapack_funcs(("potrf", "potrs"))


class FloatingTerms(NamedTuple):
    """Momenta and their known rates; rows are [base, joints], (6 + n,).

    The joint rows of ``momentum`` and ``rate`` are the classical ones (R eq. 7); the base
    rows are those of the external residual (16).
    """

    momentum: Array
    rate: Array
    internal_momentum: Array  # (n,) H_fb dq, R eq. (11)
    internal_rate: Array  # (n,)
    internal_force: Array  # (n,) what the joints feel of ``mean_force``, R eq. (12)


def floating_terms(
    mass: Array, coriolis: Array, velocity: Array, force: Array, mean_force: Array | float = 0.0
) -> FloatingTerms:
    """Return momenta and their known rates.

    Args:
        mass: Joint-space inertia M in the base's axes, (6 + n, 6 + n).
        coriolis: C with dM/dt = C + C^T, (6 + n, 6 + n).
        velocity: [base twist; joint velocities], (6 + n,).
        force: Known generalised force at this instant, such as gravity, known contacts
            and torques of the joints, (6 + n,).
        mean_force: Known generalised force that shall stay out of the rates, (6 + n,).

    Source: R eqs. (11) and (16), with w = I0^-1 p0, so that H_fb dq = p_j - F^T w. The
    joints feel f_j - F^T I0^-1 f_0 of a force, because the base gives way.
    """
    momentum = mass @ velocity
    factor, _ = _potrf(mass[:6, :6], lower=1)
    both = np.zeros((2, len(velocity)))  # v, and w with zeros behind it
    both[0] = velocity
    both[1, :6], _ = _potrs(factor, momentum[:6], lower=1)
    products = both @ coriolis
    rate = products[0] + force
    coupling = mass[:6, 6:]
    internal_momentum = momentum[6:] - both[1, :6] @ coupling
    drift = products[1] + coriolis[:, :6] @ both[1, :6]  # (C + C^T) w = dM/dt w
    np.subtract(rate, drift, out=both[0])
    both[1] = mean_force
    yielding, _ = _potrs(factor, both[:, :6].T, lower=1)
    internal_rate, internal_force = both[:, 6:] - yielding.T @ coupling
    return FloatingTerms(momentum, rate, internal_momentum, internal_rate, internal_force)
