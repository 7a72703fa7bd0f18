"""Finds the place of one touch, by one of several methods."""

import numpy as np

from estimation.contact.contact_line import ContactLine
from estimation.contact.contact_particles import ContactParticles
from estimation.contact.contact_rows import ContactRows
from estimation.contact.limb_touch import LimbTouch
from estimation.contact.link_fits import LinkFits, PlaceMethod
from estimation.contact.localisation import NOWHERE, Localisation, ranked
from estimation.contact.row_covariance import RowCovariance
from estimation.contact.surface_likelihood import SurfaceLikelihood
from estimation.contact.surface_points import SurfacePoints

Array = np.ndarray
METHODS = {"surface": SurfaceLikelihood, "line": ContactLine, "particle": ContactParticles}


class Localiser:
    """Finds the point that one touch in a sub-tree pushes at.

    Args:
        rows: At the posture of the touches.
        method: ``surface`` (the likelihood of every point), ``line`` (R section VI) or
            ``particle`` (Manuelli and Tedrake).

    Raises:
        ValueError: Unknown method; the text lists those that exist.
    """

    def __init__(self, rows: ContactRows, method: str = "surface"):
        self._rows = rows
        self.surface = SurfacePoints(rows.robot)
        self.method = self.make(method)
        subtrees = range(len(rows.robot.subtrees))
        self._bodies = [self.surface.touchable(rows.robot, i) for i in subtrees]

    def make(self, method: str) -> PlaceMethod:
        """Return a method that remembers nothing yet; ValueError for an unknown one."""
        if method not in METHODS:
            known = ", ".join(METHODS)
            raise ValueError(f"localisation method must be one of {known}, got {method!r}")
        return METHODS[method](self.surface)

    def links_of(self, subtree: int) -> list[str]:
        """Names of the links of a sub-tree that have a surface."""
        return [self._rows.robot.links[i] for i in self._bodies[subtree]]

    def fit(self, touch: Array, covariance: RowCovariance, subtree: int) -> LinkFits | None:
        """Return how well each link explains a touch, None where no link has a surface.

        Args:
            touch: Rows of the touch at the posture of the ``ContactRows``, (nv,).
            covariance: Their covariance.
            subtree: Index of the sub-tree that is touched.
        """
        bodies = self._bodies[subtree]
        if not len(bodies):
            return None
        return self.method.fit(LimbTouch(self._rows, touch, covariance, subtree, bodies))

    def locate(self, touch: Array, covariance: RowCovariance, subtree: int) -> Localisation:
        """Locate one touch for itself; arguments as those of ``fit``."""
        fits = self.fit(touch, covariance, subtree)
        return NOWHERE if fits is None else ranked(fits)
