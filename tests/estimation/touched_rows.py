"""Rows of touches on a robot at rest, made from the model: exact, or as wrong as they may be."""

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.row_covariance import RowCovariance, RowNoise
from estimation.contact.touch_locator import TouchLocator
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot
from robot_sim import Plant

Array = np.ndarray
LOOK = 50_000_000  # ns between two searches for the place


class TouchedRows:
    """A robot at home, and the rows that pushes on it give."""

    def __init__(self, robot: Robot, seed: int = 1):
        self.robot, self.surface = robot, robot.load_surface()
        plant = Plant(robot)
        self.frame = SensorPipeline(robot).step(plant.raw(), plant.time)
        self.rows = ContactRows(robot)
        self.rows.update(self.frame)
        self.covariance = RowCovariance(self.rows)
        self.covariance.update(self.frame)
        self._names = [body.name for body in self.surface.bodies]
        self._places = dict(zip(robot.links, self.rows.place_links(), strict=True))
        self._random = np.random.default_rng(seed)
        values, vectors = np.linalg.eigh(self.covariance.matrix)
        self._spread = vectors * np.sqrt(np.maximum(values, 0.0))
        self._locator = TouchLocator(self.rows, RowNoise(), 1e-3, "surface")

    def points_of(self, link: str) -> Array:
        """Indices of the surface's points on a link."""
        return np.flatnonzero(self.surface.body == self._names.index(link))

    def push(self, index: int, force: float) -> Array:
        """Rows of a force [N] into the surface at one of its points, (nv,)."""
        normal = self.surface.normals[index]
        return self.at(self.surface.link_of(index), self.surface.points[index], -force * normal)

    def at(self, link: str, point: Array, force: Array) -> Array:
        """Rows of a force [N] at a point [m], both in the frame of a link, (nv,)."""
        wrench = np.concatenate((force, np.cross(point, force)))
        wrench = self._places[link].toDualActionMatrix() @ wrench
        rows = (self.rows.layout.rows_of(link)[:, None] * self.rows.jacobian) @ wrench
        return self.rows.remove(rows, self.rows.removed)

    def noise(self, scale: float = 1.0) -> Array:
        """Errors that the covariance expects, (nv,)."""
        return scale * self._spread @ self._random.normal(size=len(self._spread))

    def between(self, one: tuple[str, Array], other: tuple[str, Array]) -> float:
        """Distance of two places, each on a link [m]."""
        places = [self._places[link].act(np.asarray(point)) for link, point in (one, other)]
        return float(np.linalg.norm(places[0] - places[1]))

    def locator(self, method: str = "surface") -> TouchLocator:
        """The locator, of which there is one, with nothing remembered."""
        self._locator.configure(1e-3, method)
        self._locator.reset()
        return self._locator


class Watch:
    """Looks at one limb again and again, as the contact detector does."""

    def __init__(self, touched: TouchedRows, limb: int, method: str = "surface"):
        self._touched, self._limb = touched, limb
        self.locator = touched.locator(method)
        self._stamp = 0

    def look(self, rows: Array):
        """Take rows, 50 ms after the last ones, and return where the touch is."""
        self._stamp += LOOK
        self.locator.add(rows, LOOK * 1e-9)
        return self.locator.search(
            self.locator.look(self._touched.frame, [self._limb], [], 0.0, self._stamp)
        )
