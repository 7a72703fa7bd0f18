"""The pure force at each of many points that explains a wrench best, in closed form.

A force f at x is the wrench F = T f, T = [1; [x]], about the origin. What is known of the
wrench, -2 log L = (F - F0)^T N (F - F0), gives the normal equations (T^T N T) f = T^T N F0,
whose entries are polynomials in x: points that do not move are raised to powers once.
"""

import numpy as np
import pinocchio as pin

Array = np.ndarray
ENTRY = 0.7  # least cosine between force and inward normal that costs nothing: friction of 1
ENTRY_COST = 10.0  # log-likelihood per unit of missing cosine; stored normals are uncertain
SKEW = np.array([pin.skew(axis) for axis in np.eye(3)])  # [x] = sum of x_k SKEW[k]
_FIRST, _SECOND = np.triu_indices(4)  # pairs in [1 x y z]; the first four are these themselves


def monomials(points: Array) -> Array:
    """Return [1 x y z xx xy xz yy yz zz] of points (P, 3), (10, P)."""
    powers = np.vstack((np.ones(len(points)), points.T))
    return powers[_FIRST] * powers[_SECOND]


def _forms() -> Array:
    """Return (42, 90): from [N, N F0] to the coefficients (9, 10) of the normal equations."""
    lift = np.zeros((4, 6, 3))  # T = sum of lift[k] [1 x y z]_k
    lift[0, :3], lift[1:, 3:] = np.eye(3), SKEW
    products = np.einsum("jac,kbd->abcdjk", lift, lift)
    products = products + products.swapaxes(-1, -2)
    products = products[..., _FIRST, _SECOND] / (1 + (_FIRST == _SECOND))
    row, column = np.triu_indices(3)
    forms = np.zeros((42, 9, 10))
    forms[:36, :6] = products[:, :, row, column].reshape(36, 6, 10)
    forms[36:, 6:, :4] = lift.transpose(1, 2, 0)
    return forms.reshape(42, 90)


_FORMS = _forms()


def normal_equations(information: Array, score: Array) -> Array:
    """Return the coefficients of ``monomials`` in the normal equations of bodies, (b, 9, 10).

    Args:
        information: N, (b, 6, 6).
        score: N F0, (b, 6).

    Returns:
        Six rows [xx xy xz yy yz zz] of T^T N T, three of T^T N F0.
    """
    known = np.concatenate((information.reshape(-1, 36), score), axis=1)
    return (known @ _FORMS).reshape(-1, 9, 10)


def point_forces(equations: Array) -> tuple[Array, Array]:
    """Solve the normal equations of many points, (9, P).

    Returns the best force at every point, (3, P) N, and the gain in -2 log L, (P,).
    """
    a, b, c, d, e, f, u, v, w = equations
    xx, xy, xz = d * f - e * e, c * e - b * f, b * e - c * d
    yy, yz, zz = a * f - c * c, b * c - a * e, a * d - b * b
    force = np.array((xx * u + xy * v + xz * w, xy * u + yy * v + yz * w, xz * u + yz * v + zz * w))
    force *= 1.0 / (a * xx + b * xy + c * xz)
    return force, (force * equations[6:]).sum(axis=0)


def entry_cost(force: Array, normals: Array) -> Array:
    """What forces (3, P) that do not press into the surface cost, (P,) in log-likelihood."""
    inward = -(force * normals).sum(axis=0)
    length = np.sqrt((force * force).sum(axis=0)) + 1e-12
    return ENTRY_COST * np.maximum(0.0, ENTRY - inward / length)
