"""Momenta of a floating-base robot and their known rates, by matrix-vector products.

R forms the matrices H_fb, dH_fb/dt and C_fb of its eqs. (9) and (13). Its residuals need
only their products with vectors, which follow from the whole robot's mass matrix M,
Coriolis matrix C (dM/dt = C + C^T) and one solve with the 6x6 base block.
"""

import numpy as np
from scipy.linalg import get_lapack_funcs

Array = np.ndarray
(_posv,) = get_lapack_funcs(("posv",))


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

    Source: R eqs. (11) to (16), with G = I0^-1 F and w = I0^-1 p0 = v_0 + G dq. The motion
    u = v - [w; 0] is that of a base without momentum: H_fb dq = (M u)_j. Of a force x the
    joints feel x_j - G^T x_0; in their rate x = C^T u - C [w; 0] + force.
    """
    gives = _posv(mass[:6, :6], mass[:6, 6:])[1]  # G, (6, n)
    w = velocity[:6] + gives @ velocity[6:]
    both, terms = np.empty((2, len(velocity))), np.empty((3, 2, len(velocity)))
    both[:] = velocity  # v and u
    both[1, :6] -= w
    np.matmul(both, mass, out=terms[0])
    np.matmul(both, coriolis, out=terms[1])
    terms[1] += force
    terms[1, 1] -= coriolis[:, :6] @ w
    terms[2] = mean_force
    felt = terms[1:, 1]
    felt[:, 6:] -= felt[:, :6] @ gives
    terms[:, 1, :6] = 0.0
    return terms
