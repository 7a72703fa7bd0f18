"""How far errors reach into the wrenches inside the robot: through a joint, and on a link."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from estimation.observer_covariance import ErrorMaps
from estimation.oriented_graph import by_center

Array = np.ndarray


def through_joint(maps: ErrorMaps, index: int) -> Array:
    """Return the errors of what a joint bears, (6, p + 6 k), about the root and in its axes.

    That is what the side of the inertial sensor exerts on the other, one column for each
    error of ``maps``. Along the joint's axis they are those of its torque.

    Args:
        maps: At the instant for which Pinocchio's data stand.
        index: The joint, in the robot's order.
    """
    graph = maps.observer.graph
    beyond = graph.bare_model.subtrees[graph.joint_ids[index]].tolist()
    errors = -maps.below[index]
    motion = np.hstack(_of_motion_beyond(maps, graph.joint_ids[index], beyond))
    start, p = motion.shape[1], maps.forces.shape[1]
    errors[:, :start] += motion
    # The root bears every body; those beyond the joint are borne by the joint too.
    borne = np.isin([body for body, _ in graph.bodies], beyond)
    of_bodies = np.concatenate([borne, np.repeat(borne, 3)])[: p - start]
    errors[:, start:p] += maps.forces[:6, start:] * of_bodies
    return errors


def _of_motion_beyond(maps: ErrorMaps, joint: int, beyond: list[int]) -> list[Array]:
    """Errors of the motion in what moves the bodies beyond a joint, which it carries.

    Joints among them move those still further out only: Pinocchio tells that.
    """
    graph = maps.observer.graph
    model, data = graph.bare_model, graph.bare_data
    bodies = [(body, model.inertias[body]) for body, _ in graph.bodies if body in beyond]
    by_velocity, by_acceleration = _carried_by(model, data, joint, bodies)
    among = np.isin(_joint_of_column(model), beyond)
    return maps.by_motion(
        np.where(among, data.dFdv, by_velocity), np.where(among, data.dFda, by_acceleration)
    )


def on_link(maps: ErrorMaps, joint: int, inertia: pin.Inertia) -> Array:
    """Return the errors of all that acts on a link, (6, ·), about the root and in its axes.

    Its mass and centre of mass are as uncertain as those of a body.

    Args:
        maps: At the instant for which Pinocchio's data stand.
        joint: Model joint that carries the link.
        inertia: Of the link, in the frame of that joint.
    """
    graph, noise = maps.observer.graph, maps.noise
    model, data = graph.bare_model, graph.bare_data
    motion = maps.by_motion(*_carried_by(model, data, joint, [(joint, inertia)]))
    regressor = pin.bodyRegressor(data.v[joint], data.a_gf[joint])
    by_parameters = data.oMi[joint].toDualActionMatrix() @ regressor
    mass = by_parameters @ inertia.toDynamicParameters() * noise.mass
    center = by_parameters @ by_center(inertia).T * noise.center_of_mass
    return np.hstack([*motion, mass[:, None], center])


def _joint_of_column(model: pin.Model) -> Array:
    """Model joint to which each of the nv columns belongs, (nv,)."""
    return np.repeat(np.arange(model.njoints), list(model.nvs))


def _carried_by(
    model: pin.Model, data: pin.Data, joint: int, bodies: Sequence[tuple[int, pin.Inertia]]
) -> tuple[Array, Array]:
    """Derivatives (6, nv) of what moves bodies, about the root, by velocity and acceleration.

    That is the sum of I a + v x* I v (Fumagalli, eqs. (3.4.4) and (3.4.5)). Columns are those
    of the joints up to ``joint``, which carry all the bodies alike; others are 0.
    """
    inertia, by_twist, momentum = pin.Inertia.Zero(), np.zeros((6, 6)), pin.Force.Zero()
    for body, own in bodies:
        about_root, velocity = data.oMi[body].act(own), data.ov[body]
        inertia += about_root
        by_twist += about_root.variation(velocity)
        momentum += about_root * velocity
    by_twist += _crossed_with(momentum)
    mass = inertia.matrix()
    carries = np.isin(_joint_of_column(model), model.supports[joint].tolist())
    by_velocity = mass @ data.dAdv + by_twist @ data.J
    return np.where(carries, by_velocity, 0.0), np.where(carries, mass @ data.J, 0.0)


def _crossed_with(momentum: pin.Force) -> Array:
    """Return the map (6, 6) of a twist v to v x* ``momentum``."""
    linear, angular = pin.skew(momentum.linear), pin.skew(momentum.angular)
    return -np.block([[np.zeros((3, 3)), linear], [linear, angular]])
