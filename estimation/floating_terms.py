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
    factor: Array  # Cholesky factor of I0


def floating_terms(mass: Array, coriolis: Array, velocity: Array, force: Array) -> FloatingTerms:
    """Return momenta and their known rates.

    Args:
        mass: Joint-space inertia M in the base's axes, (6 + n, 6 + n).
        coriolis: C with dM/dt = C + C^T, (6 + n, 6 + n).
        velocity: [base twist; joint velocities], (6 + n,).
        force: Known generalised force: gravity, known contacts, and torques of the
            joints, (6 + n,).

    Source: R eqs. (11) and (16), with w = I0^-1 p0, so that H_fb dq = p_j - F^T w.
    """
    momentum = mass @ velocity
    factor, _ = _potrf(mass[:6, :6], lower=1)
    both = np.zeros((2, len(velocity)))  # v, and w with zeros behind it
    both[0] = velocity
    both[1, :6], _ = _potrs(factor, momentum[:6], lower=1)
    rate, drift = both @ coriolis
    rate += force
    drift += coriolis[:, :6] @ both[1, :6]  # now (C + C^T) w = dM/dt w
    lost = rate - drift
    internal_momentum = momentum[6:] - both[1, :6] @ mass[:6, 6:]
    return FloatingTerms(momentum, rate, internal_momentum, felt_inside(mass, factor, lost), factor)


def felt_inside(mass: Array, factor: Array, force: Array) -> Array:
    """Return what the joints of a floating robot feel of a generalised force, (n,) N m.

    The base gives way: f_j - F^T I0^-1 f_0 (R eq. 12). ``factor`` is the Cholesky factor
    of I0 = mass[:6, :6].
    """
    yielding, _ = _potrs(factor, force[:6], lower=1)
    return force[6:] - yielding @ mass[:6, 6:]
