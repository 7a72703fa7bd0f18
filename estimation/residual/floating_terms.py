"""Momenta of a floating-base robot and their known rates, by matrix-vector products.

R forms the matrices H_fb, dH_fb/dt and C_fb of its eqs. (9) and (13). Its residuals need
only their products with vectors, which follow from the whole robot's mass matrix M,
Coriolis matrix C (dM/dt = C + C^T) and one solve with the 6x6 base block.
"""

import numpy as np
from scipy.linalg import get_lapack_funcs

Array = np.ndarray
(_posv,) = get_lapack_funcs(("posv",))


def _solve_one(inertia: Array, wrenches: Array) -> Array:
    return _posv(inertia, wrenches.T)[1].T


def _solve_many(inertia: Array, wrenches: Array) -> Array:
    return np.linalg.solve(inertia, wrenches[..., None])[..., 0]


# row times matrix, matrix times vector, solution; those for stacks take twice as long for one
_ONE = (np.ndarray.dot, np.ndarray.dot, _solve_one)
_MANY = (np.vecmat, np.matvec, _solve_many)


def floating_terms(
    mass: Array, coriolis: Array, velocity: Array, force: Array, mean_force: Array
) -> Array:
    """Return momenta, their known rates, and the mean force, (3, …, 6 + 2 n).

    The first 6 + n columns, [base, joints], are those of the external residual (R eq. 16)
    and the classical one (7). The last n are what the joints feel while the base gives
    way: H_fb dq (11), its rate, and the force (12).

    Args:
        mass: Joint-space inertia M in the base's axes, (…, 6 + n, 6 + n).
        coriolis: C with dM/dt = C + C^T, (…, 6 + n, 6 + n).
        velocity: [base twist; joint velocities], (…, 6 + n).
        force: Known generalised force at this instant, such as gravity, known contacts
            and torques of the joints, (…, 6 + n).
        mean_force: Known generalised force that shall stay out of the rates, (…, 6 + n).

    Source: R eqs. (11) to (16), with G = I0^-1 F and w = I0^-1 p0. From what the joints
    feel of x, x_j - G^T x_0, follow H_fb dq (x = M v) and its rate (x = C^T v + force
    - dM/dt [w; 0], because dG/dt^T p0 is what the joints feel of dM/dt [w; 0]).
    """
    vecmat, matvec, solve = _ONE if mass.ndim == 2 else _MANY
    inertia, coupling = mass[..., :6, :6], mass[..., :6, 6:]  # I0 and F
    momentum, rate = vecmat(velocity, mass), vecmat(velocity, coriolis)
    rate += force
    whole = np.array((momentum, rate, mean_force))
    w = solve(inertia, momentum[..., :6])
    felt = whole.copy()
    felt[1] -= matvec(coriolis[..., :6], w)
    felt[1] -= vecmat(w, coriolis[..., :6, :])
    given = vecmat(solve(inertia, felt[..., :6]), coupling)
    return np.concatenate((whole, felt[..., 6:] - given), axis=-1)
