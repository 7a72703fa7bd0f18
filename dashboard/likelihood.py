"""The surface, coloured by how probable a touch is there."""

import numpy as np
import viser

from robot_model.messages import ContactMap

from .probability_colours import probability_colours

Array = np.ndarray

MOST = 3000  # points drawn; links where a touch is improbable are left out first
SIZE = 0.011  # [m]; the points are 10 mm apart


class Likelihood:
    """A cloud of dots on each body that may be touched.

    The clouds hang on the bodies and move with them; of a new map only the colours
    are sent again.
    """

    def __init__(self, scene: viser.SceneApi, paths: dict[str, str]):
        self._scene, self._paths = scene, paths
        self._clouds: dict[str, viser.PointCloudHandle] = {}
        self._shown: ContactMap | None = None

    def show(self, found: ContactMap | None) -> None:
        """Draw a map, or nothing."""
        if found is self._shown:
            return
        self._shown = found
        parts = {} if found is None else drawn_parts(found)
        for link, cloud in self._clouds.items():
            cloud.visible = link in parts
        most = max((probability.max() for _, probability in parts.values()), default=0.0) or 1.0
        for link, (points, probability) in parts.items():
            if link in self._paths:
                self._draw(link, points.astype(np.float32), probability_colours(probability / most))

    def _draw(self, link: str, points: Array, colours: Array) -> None:
        cloud = self._clouds.get(link)
        if cloud is None:
            self._clouds[link] = self._scene.add_point_cloud(
                f"{self._paths[link]}/likelihood",
                points,
                colours,
                point_size=SIZE,
                point_shape="circle",
                precision="float32",
            )
            return
        if not np.array_equal(cloud.points, points):
            cloud.points = points
        if not np.array_equal(cloud.colors, colours):
            cloud.colors = colours


def drawn_parts(found: ContactMap) -> dict[str, tuple[Array, Array]]:
    """Return points (m, 3) [m] in the link's frame and probabilities (m,) of the likeliest links.

    As many links as together have no more than ``MOST`` points.
    """
    ends = np.cumsum(found.count)[:-1]
    points = np.split(found.point, ends)
    probabilities = np.split(found.probability, ends)
    sums = np.array([part.sum() for part in probabilities])
    order = np.argsort(-sums)[: len(found.link)]
    fitting = np.cumsum(np.array(found.count, dtype=int)[order]) <= MOST
    return {found.link[i]: (points[i], probabilities[i]) for i in order[fitting]}
