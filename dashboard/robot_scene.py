"""The robot's body in the browser."""

import numpy as np
import viser

from robot_model.surface import Surface

from .light_mesh import lighten

Array = np.ndarray

BODY = np.array([172, 180, 190])  # a robot that is alive
STALE = np.array([70, 72, 76])  # and one of which nothing is heard
TOUCHED = np.array([232, 62, 190])
SHADES = 8  # steps between untouched and touched: fewer messages to the browser

CELL = 0.008  # [m]; a frame drawn in software took 0.67 s of a core with all 125 000 triangles

STILL_POSITION = 5e-4  # [m]; smaller moves are less than a pixel and not sent
STILL_QUATERNION = 4e-4  # 0.8 mrad


class RobotScene:
    """One mesh per body, hung on the body that carries it.

    A body is sent again only when its joint moved or its colour changed: sending a
    pose takes viser 0.1 ms, and 39 bodies that all moved in the world took 9 ms.
    """

    def __init__(self, scene: viser.SceneApi, surface: Surface, parents: tuple[int, ...]):
        self.links = tuple(body.name for body in surface.bodies)
        self.parents = parents
        paths = _paths(self.links, parents)
        self.paths = dict(zip(self.links, paths, strict=True))  # names in the scene
        self._meshes = [
            _add_mesh(scene, path, *lighten(body.vertices, body.triangles, CELL))
            for path, body in zip(paths, surface.bodies, strict=True)
        ]
        self._poses = np.full((len(self.links), 7), np.inf)
        self._shades = np.full(len(self.links), -1)

    def place(self, poses: Array) -> None:
        """Move the bodies to positions and quaternions xyzw in their parents, (bodies, 7)."""
        change = np.abs(poses - self._poses)
        moved = (change[:, :3] > STILL_POSITION).any(1)
        turned = (change[:, 3:] > STILL_QUATERNION).any(1)
        for i in np.flatnonzero(moved):
            self._meshes[i].position = poses[i, :3]
        for i in np.flatnonzero(turned):
            self._meshes[i].wxyz = poses[i, [6, 3, 4, 5]]
        self._poses[moved, :3] = poses[moved, :3]
        self._poses[turned, 3:] = poses[turned, 3:]

    def shade(self, touched: Array, stale: bool) -> None:
        """Colour the bodies by the probability that each is touched, (bodies,); grey when stale."""
        shades = np.full(len(self.links), SHADES + 1) if stale else _steps(touched)
        for i in np.flatnonzero(shades != self._shades):
            self._meshes[i].color = _colour(shades[i])
        self._shades = shades


def _add_mesh(
    scene: viser.SceneApi, path: str, vertices: Array, triangles: Array
) -> viser.MeshHandle:
    return scene.add_mesh_simple(
        path,
        vertices.astype(np.float32),
        triangles.astype(np.uint32),
        color=(int(BODY[0]), int(BODY[1]), int(BODY[2])),
        flat_shading=True,
        cast_shadow=False,
        receive_shadow=False,
    )


def _paths(links: tuple[str, ...], parents: tuple[int, ...]) -> list[str]:
    """Return scene names such as /robot/root_link/torso_1; a parent may come after its child."""

    def path(i: int) -> str:
        return f"{path(parents[i]) if parents[i] >= 0 else '/robot'}/{links[i]}"

    return [path(i) for i in range(len(links))]


def _steps(touched: Array) -> Array:
    return np.rint(np.clip(touched, 0.0, 1.0) * SHADES).astype(int)


def _colour(shade: int) -> tuple[int, int, int]:
    rgb = STALE if shade > SHADES else BODY + (TOUCHED - BODY) * shade // SHADES
    return int(rgb[0]), int(rgb[1]), int(rgb[2])
