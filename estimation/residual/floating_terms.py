"""Momenta of a floating-base robot and their known rates, by matrix-vector products.

R forms the matrices H_fb, dH_fb/dt and C_fb of its eqs. (9) and (13). Its residuals need
only their products with vectors, which follow from the whole robot's mass matrix M,
Coriolis matrix C (dM/dt = C + C^T) and one solve with the 6x6 base block.
"""

import numpy as np
from scipy.linalg import get_lapack_funcs

Array = np.ndarray
_potrf, _potrs = get_lapack_funcs(("potrf", "potrs"))


def floating_terms(
    mass: Array, coriolis: Array, velocity: Array, force: Array, mean_force: Array | float = 0.0
) -> Array:
    """Return momenta, their known rates, and the mean force, (3, 2, 6 + n).

    Of each the first row, [base, joints], is that of the external residual (R eq. 16) and
    the classical one (7). The second, [0, joints], is what the joints feel while the base
    gives way: H_fb dq (11), its rate, and the force (12).

    Args:
        mass: Joint-space inertia M in the base's axes, (6 + n, 6 + n).
        coriolis: C with dM/dt = C + C^T, (6 + n, 6 + n).
        velocity: [base twist; joint velocities], (6 + n,).
        force: Known generalised force at this instant, such as gravity, known contacts
            and torques of the joints, (6 + n,).
        mean_force: Known generalised force that shall stay out of the rates, (6 + n,).

    Source: R eqs. (11) to (16), with G = I0^-1 F and w = I0^-1 p0. From what the joints
    feel of x, x_j - G^T x_0, follow H_fb dq (x = M v) and its rate (x = C^T v + force
    - dM/dt [w; 0], because dG/dt^T p0 is what the joints feel of dM/dt [w; 0]).
    """
    inertia, coupling = _potrf(mass[:6, :6])[0], mass[:6, 6:]  # I0, factorised, and F
    momentum, rate = velocity.dot(mass), velocity.dot(coriolis)
    rate += force
    w = _potrs(inertia, momentum[:6])[0]
    terms = np.zeros((3, 2, len(velocity)))
    terms[0], terms[1], terms[2] = momentum, rate, mean_force
    felt = terms[:, 1]
    felt[1] -= coriolis[:, :6].dot(w)
    felt[1] -= w.dot(coriolis[:6])
    by_base = _potrs(inertia, felt[:, :6].T)[0]
    felt[:, 6:] -= by_base.T.dot(coupling)
    felt[:, :6] = 0.0
    return terms
