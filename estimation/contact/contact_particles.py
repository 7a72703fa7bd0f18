"""A particle filter on the robot's surface, in the manner of Manuelli and Tedrake."""

from dataclasses import dataclass

import numpy as np

from estimation.contact.limb_touch import LimbTouch
from estimation.contact.link_fits import LinkFits, Places
from estimation.contact.point_forces import monomials, normal_equations, point_forces
from estimation.contact.surface_points import SurfacePoints

Array = np.ndarray
PARTICLES = 400
ROUNDS = 3  # predictions and resamplings per sample of the rows
NEIGHBOURS = 24  # stored points that a particle may move to; about 25 mm around it
OFFSET = 0.004  # m, spread of the particles about their stored points, within the surface
ANEW = 0.05  # share of particles that are drawn anew anywhere, so that touches may change
FRICTION = 1.0  # coefficient: half angle of 45 degrees, as in the paper
CLUSTER = 0.02  # m about the best particle of a link of which the place is the mean
SEED = 0  # equal touches give equal answers


@dataclass
class _Cloud:
    """Particles of one touch: index of a stored point of the limb, and place in its link."""

    index: Array  # (n,)
    point: Array  # (n, 3) m


class _LimbSurface:
    """All stored points of the links of one limb, and where each leads to."""

    def __init__(self, surface: SurfacePoints, touch: LimbTouch):
        from scipy.spatial import KDTree

        names = touch.names(touch.bodies)
        sizes = [len(surface.points[name]) for name in names]
        self.links = names
        self.owner = np.repeat(np.arange(len(names)), sizes)
        self.point, self.normal = surface.all_of(names)
        placed = np.concatenate(_at_home(surface, touch, names))
        number = min(NEIGHBOURS, len(placed))
        self.neighbours = KDTree(placed).query(placed, k=number)[1].reshape(len(placed), number)


def _at_home(surface: SurfacePoints, touch: LimbTouch, names: list[str]) -> list[Array]:
    """Points of each link in the root's frame, at the posture of the first touch."""
    places = dict(zip(touch.rows.robot.links, touch.rows.place_links(), strict=True))
    return [surface.points[x] @ places[x].rotation.T + places[x].translation for x in names]


class ContactParticles:
    """The contact particle filter, one set of particles per touched limb.

    A particle is a place on the surface. Its likelihood is that of the best force in its
    friction cone; particles move along the surface, from link to link too, and are
    resampled. Each limb has one touch. Source: L. Manuelli and R. Tedrake, Localizing
    external contact using proprioceptive sensors: the contact particle filter (2016).
    """

    def __init__(self, surface: SurfacePoints):
        self._surface = surface
        self._limbs: dict[int, _LimbSurface] = {}
        self._clouds: dict[int, _Cloud] = {}
        self._random = np.random.default_rng(SEED)

    def forget(self, subtree: int) -> None:
        """Let the next touch of a limb begin anywhere."""
        self._clouds.pop(subtree, None)

    def fit(self, touch: LimbTouch) -> LinkFits:
        """Move, weigh and resample the particles; return the best touch of every link."""
        if touch.subtree not in self._limbs:
            self._limbs[touch.subtree] = _LimbSurface(self._surface, touch)
        limb = self._limbs[touch.subtree]
        everywhere = touch.evidence.seen_by(
            np.arange(len(touch.bodies)), touch.rows.link_maps(touch.bodies)
        )
        forms = normal_equations(*everywhere)
        cloud = self._clouds.get(touch.subtree) or self._drawn(limb, PARTICLES)
        for _ in range(ROUNDS):
            cloud = self._moved(limb, cloud)
            force, value = _weigh(limb, cloud, forms)
            weighed = cloud
            cloud = self._resampled(cloud, value)
        self._clouds[touch.subtree] = cloud
        return _summary(limb, weighed, force, value, touch)

    def _drawn(self, limb: _LimbSurface, number: int) -> _Cloud:
        index = self._random.choice(len(limb.point), number)
        return _Cloud(index, limb.point[index])

    def _moved(self, limb: _LimbSurface, cloud: _Cloud) -> _Cloud:
        """Move particles to places near their own, some of them anywhere."""
        random, number = self._random, len(cloud.index)
        step = random.integers(limb.neighbours.shape[1], size=number)
        index = limb.neighbours[cloud.index, step]
        anew = random.uniform(size=number) < ANEW
        index[anew] = random.choice(len(limb.point), int(anew.sum()))
        offset = OFFSET * random.normal(size=(number, 3))
        normal = limb.normal[index]
        offset -= normal * np.vecdot(normal, offset)[:, None]
        return _Cloud(index, limb.point[index] + offset)

    def _resampled(self, cloud: _Cloud, value: Array) -> _Cloud:
        """Draw particles by their weight, with the low variance of one random number."""
        weight = np.exp(value - value.max())
        share = np.cumsum(weight) / weight.sum()
        number = len(weight)
        grid = (np.arange(number) + self._random.uniform()) / number
        kept = np.minimum(np.searchsorted(share, grid), number - 1)
        return _Cloud(cloud.index[kept], cloud.point[kept])


def _weigh(limb: _LimbSurface, cloud: _Cloud, forms: Array) -> tuple[Array, Array]:
    """Return the best force in each particle's friction cone (3, n), and its log-likelihood."""
    own = forms[limb.owner[cloud.index]]
    equations = np.matvec(own, monomials(cloud.point).T).T
    force, gain = point_forces(equations)
    inward = -limb.normal[cloud.index].T
    axial = (force * inward).sum(axis=0)
    across = force - axial * inward
    size = np.sqrt((across * across).sum(axis=0)) + 1e-12
    outside = size > FRICTION * axial
    # the nearest edge of the cone; the best force along it has a closed form
    edge = inward + FRICTION * across / size
    a, b, c, d, e, f = equations[:6]
    x, y, z = edge
    bent = a * x * x + d * y * y + f * z * z + 2.0 * (b * x * y + c * x * z + e * y * z)
    along = np.maximum((equations[6:] * edge).sum(axis=0), 0.0)
    force = np.where(outside, along / bent * edge, force)
    return force, 0.5 * np.where(outside, along * along / bent, gain)


def _summary(
    limb: _LimbSurface, cloud: _Cloud, force: Array, value: Array, touch: LimbTouch
) -> LinkFits:
    """Return the best place of every link that has particles."""
    owner = limb.owner[cloud.index]
    order = np.lexsort((-value, owner))
    found, first, count = np.unique(owner[order], return_index=True, return_counts=True)
    groups = np.split(order, first[1:])
    clusters = [_cluster(cloud.point[g], force[:, g].T, value[g]) for g in groups]
    weight, mean, covariance = (np.array(part) for part in zip(*clusters, strict=True))
    links = [limb.links[i] for i in found]
    return LinkFits(
        links=links,
        weight=weight,
        point=mean[:, :3],
        force=mean[:, 3:],
        covariance=covariance,
        misfit=float(touch.free_gain.max() - value.max()),
        places=lambda: Places(links, count.tolist(), cloud.point[order], value[order]),
    )


def _cluster(point: Array, force: Array, value: Array) -> tuple[float, Array, Array]:
    """Return log of the summed weights of one link, and mean and covariance about its best."""
    weight = np.exp(value - value[0])
    near = np.linalg.norm(point - point[0], axis=1) < CLUSTER
    share = weight[near] / weight[near].sum()
    touches = np.hstack((point, force))[near]
    mean = share @ touches
    spread = (touches - mean).T @ (share[:, None] * (touches - mean))
    return float(value[0] + np.log(weight.sum())), mean, spread + 1e-6 * np.eye(6)
