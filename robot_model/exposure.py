"""Which points of a robot's surface can be touched from outside.

CAD meshes are not closed and are full of inner faces, so inside and outside cannot be
told by their topology. Instead the robot is looked at from many directions, in some
postures, and a point is exposed when it is seen from at least half of the directions
within 60 degrees of one side of its face. That side is outside.
"""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from robot_model.meshes import Body, cell_keys
from robot_model.robot import Robot

SAMPLE = 0.0025  # m between the samples of a face
PIXEL = 0.005  # m; four samples or more fall into each, so that outer faces have no holes
SPACING = 0.010  # m between exposed points
AXES = 48  # lines of sight, each looked along both ways
CONE = 0.5  # cosine: directions within 60 degrees of the normal count
VISIBLE = 0.5  # share of those directions that must see the point
POSTURES = 3  # besides home


def exposed_points(
    robot: Robot, bodies: Sequence[Body]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (P, 3) m, outward normals (P, 3), and body indices (P,).

    Points and normals are in the frame of their body's main link.
    """
    if not bodies:
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, dtype=int)
    samples = [sample_faces(body, seed) for seed, body in enumerate(bodies)]
    points = np.concatenate([points for points, _ in samples])
    normals = np.concatenate([normals for _, normals in samples])
    owner = np.repeat(np.arange(len(bodies)), [len(points) for points, _ in samples])
    outward = np.zeros(len(points))
    best = np.zeros(len(points))
    for q in postures(robot):
        rotations, positions = _poses(robot, bodies, q)
        world = np.einsum("nij,nj->ni", rotations[owner], points) + positions[owner]
        facing = np.einsum("nij,nj->ni", rotations[owner], normals)
        shares = visible_shares(world.astype(np.float32), facing.astype(np.float32))
        share, side = shares.max(axis=0), np.where(shares[0] >= shares[1], 1.0, -1.0)
        outward = np.where(share > best, side, outward)
        best = np.maximum(best, share)
    seen = best >= VISIBLE
    return thin(points[seen], normals[seen] * outward[seen, None], owner[seen], best[seen])


def postures(robot: Robot) -> list[np.ndarray]:
    """Home, and seeded postures half way from home to anywhere within the limits."""
    random = np.random.default_rng(0)
    lower = np.maximum(robot.position_lower, -np.pi)
    upper = np.minimum(robot.position_upper, np.pi)
    anywhere = [random.uniform(lower, upper) for _ in range(POSTURES)]
    return [robot.home, *((robot.home + q) / 2 for q in anywhere)]


def _poses(robot: Robot, bodies: Sequence[Body], q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    data = robot.tree.model.createData()
    pin.framesForwardKinematics(robot.tree.model, data, robot.tree.configuration(q))
    poses = [data.oMf[robot.tree.frame_id(body.name)] for body in bodies]
    return np.array([p.rotation for p in poses]), np.array([p.translation for p in poses])


def sample_faces(body: Body, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points on a body's faces, one per small cell, and their face normals."""
    corners = body.vertices[body.triangles]
    edges = corners[:, 1:] - corners[:, :1]
    cross = np.cross(edges[:, 0], edges[:, 1])
    length = np.linalg.norm(cross, axis=1)
    random = np.random.default_rng(seed)
    number = random.poisson(length / 2 / (0.5 * SAMPLE**2)) + 1
    face = np.repeat(np.arange(len(corners)), number)
    uv = random.random((len(face), 2))
    uv = np.where(uv.sum(axis=1, keepdims=True) > 1.0, 1.0 - uv, uv)
    points = corners[face, 0] + (uv[:, :, None] * edges[face]).sum(axis=1)
    normals = cross / np.maximum(length, 1e-12)[:, None]
    _, kept = np.unique(cell_keys(points, SAMPLE), return_index=True)
    return points[kept], normals[face[kept]]


def visible_shares(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the share of directions that see each side of each point, (2, N).

    Row 0 is the side of the normal, row 1 the other one. Depth buffers of pixels of
    ``PIXEL``; the tolerance grows with the slope that a pixel spans.
    """
    seen = np.zeros((2, len(points)), dtype=np.float32)
    asked = np.zeros(len(points), dtype=np.float32)
    for axis in sight_lines(AXES):
        depth = points @ axis
        pixel = _pixels(points @ _plane(axis))
        cosine = normals @ axis
        steep = np.abs(cosine)
        tolerance = 0.001 + 0.7 * PIXEL * np.sqrt(1.0 - np.minimum(steep, 1.0) ** 2) / (
            np.maximum(steep, CONE)
        )
        near = np.full(pixel.max() + 1, np.inf, dtype=np.float32)
        far = np.full(pixel.max() + 1, -np.inf, dtype=np.float32)
        np.minimum.at(near, pixel, depth)
        np.maximum.at(far, pixel, depth)
        counted = steep > CONE
        forward = cosine < 0.0  # looking along the axis, this side of the face is seen
        from_near = counted & (depth <= near[pixel] + tolerance)
        from_far = counted & (depth >= far[pixel] - tolerance)
        seen[0] += np.where(forward, from_near, from_far)
        seen[1] += np.where(forward, from_far, from_near)
        asked += counted
    return seen / np.maximum(asked, 1.0)


def sight_lines(count: int) -> np.ndarray:
    """Return unit vectors spread evenly over half a sphere, (count, 3)."""
    z = (np.arange(count) + 0.5) / count
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    radius = np.sqrt(1.0 - z**2)
    lines = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
    return lines.astype(np.float32)


def _plane(axis: np.ndarray) -> np.ndarray:
    """Two unit vectors across an axis, as columns (3, 2)."""
    u = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(axis, u)], axis=1).astype(np.float32)


def _pixels(flat: np.ndarray) -> np.ndarray:
    cells = ((flat - flat.min(axis=0)) / np.float32(PIXEL)).astype(np.int32)
    return cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1]


def thin(
    points: np.ndarray, normals: np.ndarray, owner: np.ndarray, score: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Keep one point per body and cell of ``SPACING``: the best seen, with a smooth normal."""
    cells = cell_keys(points, SPACING)
    _, group = np.unique(cells * (owner.max() + 1) + owner, return_inverse=True)
    order = np.lexsort((-score, group))
    chosen = order[np.flatnonzero(np.diff(group[order], prepend=-1))]
    agree = np.einsum("ni,ni->n", normals, normals[chosen][group]) > CONE
    sums = [np.bincount(group[agree], weights=n[agree]) for n in normals.T]
    smooth = np.stack(sums, axis=1)
    smooth /= np.linalg.norm(smooth, axis=1, keepdims=True)
    return points[chosen], smooth, owner[chosen]
