"""Where on the robot's surface a pure force explains the rows of a touch best."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from robot_model import Robot

Array = np.ndarray
ENTRY = 0.5  # least cosine between a force and the inward normal that costs nothing
ENTRY_COST = 30.0  # log-likelihood per unit of missing cosine


@dataclass(frozen=True, eq=False)
class BodyEvidence:
    """What the rows say of a wrench on one body: -2 log L = (F - F0)^T N (F - F0) + const."""

    information: Array  # N, (6, 6), of [f m] in the root's axes
    score: Array  # N F0, (6,)

    @property
    def gain(self) -> float:
        """Drop of -2 log L that a free wrench on the body brings (D of a chi-square test)."""
        return float(self.score @ np.linalg.solve(self.information, self.score))


@dataclass(frozen=True, eq=False)
class PointFit:
    """The best touch on one body, in the root's axes."""

    log_likelihood: float  # of the best point, with what its normal costs
    spread: float  # log of the number of points that are about as good
    point: Array  # (3,) m
    force: Array  # (3,) N
    covariance: Array  # (6, 6) of [point, force]


def body_evidence(bears: Array, jacobian: Array, information: Array, rows: Array) -> BodyEvidence:
    """Return the evidence for a wrench that appears in some rows.

    Args:
        bears: (nv,) bool, rows in which a wrench on the body appears.
        jacobian: (nv, 6), see ``ContactRows``.
        information: (nv, nv) inverse covariance of the rows.
        rows: (nv,) rows of the touch.
    """
    columns = jacobian * bears[:, None]
    weighted = information @ columns
    return BodyEvidence(columns.T @ weighted, weighted.T @ rows)


class SurfaceLikelihood:
    """Exposed points of every body, and the likelihood of a touch at each.

    A touch is a pure force at a point of the surface, pressing inwards. For every point
    the best force has a closed form, so that all points are simply tried.
    """

    def __init__(self, robot: Robot):
        surface = robot.load_surface()
        self.points: dict[str, Array] = {}  # (P, 3) in the link's frame, by link
        self.normals: dict[str, Array] = {}
        for index, body in enumerate(surface.bodies):
            mine = surface.body == index
            if mine.any():
                self.points[body.name] = surface.points[mine]
                self.normals[body.name] = surface.normals[mine]

    def fit(self, link: str, evidence: BodyEvidence, placement: pin.SE3) -> PointFit:
        """Return the best touch on a link that sits at ``placement`` in the root's frame."""
        rotation = placement.rotation
        points = self.points[link] @ rotation.T + placement.translation
        normals = self.normals[link] @ rotation.T
        force, gain = point_forces(points, evidence)
        value = 0.5 * gain - entry_cost(force, normals)
        best = int(value.argmax())
        spread = float(np.log(np.exp(value - value[best]).sum()))
        return _refined(points, normals, best, force[best], spread, evidence)


def entry_cost(force: Array, normals: Array) -> Array:
    """What a force that does not press into the surface costs, (P,) in log-likelihood."""
    inward = -np.einsum("ij,ij->i", force, normals)
    length = np.sqrt(np.einsum("ij,ij->i", force, force)) + 1e-12
    return ENTRY_COST * np.maximum(0.0, ENTRY - inward / length)


def point_forces(points: Array, evidence: BodyEvidence) -> tuple[Array, Array]:
    """Return the best force at every point, (P, 3) N, and the gain in -2 log L, (P,).

    With F = T f, T = [1; [x]], normal equations are quadratic in x: (T^T N T) f = T^T N F0.
    """
    features = np.empty((len(points), 13))
    features[:, 0] = 1.0
    features[:, 1:4] = points
    np.multiply(points[:, :, None], points[:, None, :], out=features[:, 4:].reshape(-1, 3, 3))
    values = features @ _coefficients(evidence)
    force = _solve_symmetric(values[:, :6].T, values[:, 6:].T).T
    return force, np.einsum("ij,ij->i", force, values[:, 6:])


def _coefficients(evidence: BodyEvidence) -> Array:
    """Coefficients (13, 9) of [1, x, x x^T] in [xx xy xz yy yz zz] of T^T N T, and T^T N F0."""
    info, score = evidence.information, evidence.score
    cross = np.array([pin.skew(axis) for axis in np.eye(3)])  # [e_k], so that [x] = x_k [e_k]
    mixed = info[:3, 3:] @ cross
    result = np.zeros((13, 3, 3))
    result[0] = info[:3, :3]
    result[1:4] = mixed + mixed.transpose(0, 2, 1)
    squares = cross.transpose(0, 2, 1)[:, None] @ info[3:, 3:] @ cross[None]
    result[4:] = squares.reshape(9, 3, 3)
    upper = np.triu_indices(3)
    right = np.zeros((13, 3))
    right[0] = score[:3]
    right[1:4] = -cross @ score[3:]
    return np.concatenate((result[:, upper[0], upper[1]], right), axis=1)


def _solve_symmetric(matrix: Array, right: Array) -> Array:
    """Solve many symmetric 3x3 systems: (6, P) [xx xy xz yy yz zz], (3, P) -> (3, P)."""
    a, b, c, d, e, f = matrix
    u, v, w = right
    xx, xy, xz = d * f - e * e, c * e - b * f, b * e - c * d
    yy, yz, zz = a * f - c * c, b * c - a * e, a * d - b * b
    scale = 1.0 / (a * xx + b * xy + c * xz)
    solution = (xx * u + xy * v + xz * w, xy * u + yy * v + yz * w, xz * u + yz * v + zz * w)
    return np.array(solution) * scale


SHIFT = 0.006  # m, how far a touch may lie from the nearest stored point, one sigma
DEPTH = 0.002  # m, how well the surface's depth is known, one sigma


def _refined(
    points: Array, normals: Array, best: int, force: Array, spread: float, evidence: BodyEvidence
) -> PointFit:
    """Move the best stored point within the surface to where the likelihood is largest.

    Stored points are 10 mm apart; an exact sensor tells more than that.
    """
    wrench = np.linalg.solve(evidence.information, evidence.score)
    point = points[best]
    for _ in range(3):
        near = int(((points - point) ** 2).sum(axis=1).argmin())
        anchor, normal = points[near], normals[near]
        point = point - normal * (normal @ (point - anchor))  # onto the tangent plane
        prior = _shift_information(normal)
        slope = np.zeros((6, 6))  # of the wrench by [point, force]
        slope[:3, 3:] = np.eye(3)
        slope[3:, :3], slope[3:, 3:] = -pin.skew(force), pin.skew(point)
        curvature = slope.T @ evidence.information @ slope
        curvature[:3, :3] += prior
        predicted = np.concatenate((force, np.cross(point, force)))
        descent = slope.T @ evidence.information @ (wrench - predicted)
        descent[:3] -= prior @ (point - anchor)
        step = np.linalg.solve(curvature, descent)
        point, force = point + step[:3], force + step[3:]
    miss = wrench - np.concatenate((force, np.cross(point, force)))
    shift = point - anchor
    cost = miss @ evidence.information @ miss + shift @ prior @ shift
    value = 0.5 * (evidence.score @ wrench - cost)
    value -= float(entry_cost(force[None], normal[None])[0])
    return PointFit(float(value), spread, point, force, np.linalg.inv(curvature))


def _shift_information(normal: Array) -> Array:
    across = np.outer(normal, normal)
    return (np.eye(3) - across) / SHIFT**2 + across / DEPTH**2
