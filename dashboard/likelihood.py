"""The surface, coloured by how probable a touch is there."""

import time

import numpy as np
import viser

from robot_model.messages import ContactMap
from robot_model.surface import Surface

from .probability_colours import probability_colours
from .rhythm import Rhythm

Array = np.ndarray

SIZE = 0.012  # [m]; the points are 10 mm apart
LIFT = 0.006  # [m] outwards, so that the lighter mesh that is drawn hides no dot
FAINT = 1e-3  # of the most probable place; less is not drawn


class Likelihood:
    """A cloud of dots on each body that may be touched; it hangs on the body and moves with it."""

    def __init__(self, scene: viser.SceneApi, paths: dict[str, str], surface: Surface, rate: float):
        self._scene, self._paths, self._surface = scene, paths, surface
        self._rhythm = Rhythm(rate)
        self._clouds: dict[str, viser.PointCloudHandle] = {}
        self._shown: ContactMap | None = None

    def show(self, found: ContactMap | None) -> None:
        """Draw a map, or nothing."""
        if found is self._shown or (found is not None and not self._rhythm.due(time.monotonic())):
            return
        self._shown = found
        parts = {} if found is None else drawn_parts(found)
        for link, cloud in self._clouds.items():
            cloud.visible = link in parts
        for link, (points, brightness) in parts.items():
            if link in self._paths:
                self._draw(link, self._lifted(link, points), probability_colours(brightness))

    def _draw(self, link: str, points: Array, colours: Array) -> None:
        if (cloud := self._clouds.get(link)) is not None:
            cloud.points, cloud.colors = points, colours
            return
        self._clouds[link] = self._scene.add_point_cloud(
            f"{self._paths[link]}/likelihood",
            points,
            colours,
            point_size=SIZE,
            point_shape="circle",
            precision="float32",
        )

    def _lifted(self, link: str, points: Array) -> Array:
        body = [body.name for body in self._surface.bodies].index(link)
        own = self._surface.body == body
        nearest = _nearest(points, self._surface.points[own])
        return (points + LIFT * self._surface.normals[own][nearest]).astype(np.float32)


def _nearest(points: Array, among: Array) -> Array:
    """Return the index of the nearest of ``among``, (k, 3), to each point, (m, 3)."""
    return np.argmin((among**2).sum(axis=1) - 2.0 * points @ among.T, axis=1)


def drawn_parts(found: ContactMap) -> dict[str, tuple[Array, Array]]:
    """Return by link the points (m, 3) [m] that are drawn, in its frame, and brightness (m,).

    The brightness is 1 at the most probable place and falls with the logarithm of the
    probability, to 0 where that is ``FAINT`` of the highest.
    """
    if not len(found.probability):
        return {}
    with np.errstate(divide="ignore"):
        brightness = 1.0 - np.log(found.probability / found.probability.max()) / np.log(FAINT)
    ends = np.cumsum(found.count)[:-1]
    parts = zip(found.link, np.split(found.point, ends), np.split(brightness, ends), strict=True)
    return {link: (p[b >= 0.0], b[b >= 0.0]) for link, p, b in parts if (b >= 0.0).any()}
