"""Pinocchio models of a robot, rooted anywhere and cut at its force/torque sensors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from robot_model.names import did_you_mean
from robot_model.robot import Robot
from robot_model.urdf import Joint, Urdf

Leaf = tuple[str, str, pin.SE3]  # name, URDF link or frame, placement in that link


@dataclass(frozen=True, eq=False)
class TreeModel:
    """A Pinocchio model and where the robot's joints, cuts and leaves lie in it.

    The root is a free-flyer whose frame is the URDF frame ``root``. Joint positions,
    velocities and torques keep the URDF's sign wherever the root is. The torque
    that inverse dynamics gives for a cut is the wrench [f m] in the axes and about
    the origin of the sensor's frame; times ``cut_sign`` it is the sensor's reading.
    """

    model: pin.Model
    root: str
    joint_q: np.ndarray  # (n,) index of each joint of the description in q
    joint_v: np.ndarray  # (n,) index of each joint of the description in v
    cut_v: np.ndarray  # (k, 6) indices of each sensor in v; (0, 6) without cuts
    cut_q: np.ndarray  # (k,) start of each sensor's seven numbers in q
    cut_sign: np.ndarray  # (k,) +1 where the model's parent is the URDF's parent
    leaf_v: Mapping[str, np.ndarray]  # (6,) indices in v, by leaf
    frame_ids: Mapping[str, int]  # Pinocchio frame of every URDF link
    neutral: np.ndarray = field(repr=False)  # (nq,)

    def frame_id(self, name: str) -> int:
        """Return the Pinocchio frame of a URDF link or frame."""
        if name not in self.frame_ids:
            raise LookupError(f"no frame '{name}'{did_you_mean(name, self.frame_ids)}")
        return self.frame_ids[name]

    def configuration(
        self,
        q: np.ndarray,
        base: pin.SE3 | np.ndarray | None = None,
        out: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return Pinocchio's configuration (nq,).

        Args:
            q: Joint positions, (n,) rad.
            base: Pose of the root frame in the world: SE3, or (7,) position and
                quaternion xyzw; identity when None (unchanged in ``out``).
            out: Array from an earlier call, written in place.
        """
        full = self.neutral.copy() if out is None else out
        full[self.joint_q] = q
        if base is not None:
            full[:7] = pin.SE3ToXYZQUAT(base) if isinstance(base, pin.SE3) else base
        return full

    def velocity(
        self, dq: np.ndarray, twist: np.ndarray | None = None, out: np.ndarray | None = None
    ) -> np.ndarray:
        """Return Pinocchio's velocity (nv,); the same layout serves accelerations.

        Args:
            dq: Joint velocities, (n,) rad/s.
            twist: Twist [v w] of the root, (6,) in root axes; zero when None
                (unchanged in ``out``).
            out: Array from an earlier call, written in place.
        """
        full = np.zeros(self.model.nv) if out is None else out
        full[self.joint_v] = dq
        if twist is not None:
            full[:6] = twist
        return full


def build_tree(
    robot: Robot,
    root: str | None = None,
    cut: bool = False,
    leaves: Sequence[Leaf] = (),
    perturbation: Mapping[str, float] | None = None,
) -> TreeModel:
    """Build a model of the robot.

    Args:
        robot: The robot.
        root: URDF link or frame that bears the free-flyer; the base link when None.
        cut: Make every force/torque sensor a six-dof joint (to be kept at zero motion),
            in the sensor's frame. Otherwise its two sides are one rigid body.
        leaves: Massless free-flyers to add: name, URDF link or frame, placement in it.
        perturbation: Factors of mass and inertia by URDF link.

    Raises:
        LookupError: Unknown root, or unknown link of a leaf.
    """
    root = robot.base_link if root is None else root
    for name in (root, *(link for _, link, _ in leaves)):
        robot.frame(name)
    urdf = robot.urdf.scaled(perturbation) if perturbation else robot.urdf
    builder = _Builder(urdf, _cut_frames(robot) if cut else {}, leaves)
    builder.grow(root)
    return builder.finish(robot, root, cut)


def _cut_frames(robot: Robot) -> dict[str, pin.SE3]:
    """Placement of each sensor's frame in the parent link of its joint, by joint."""
    placements = robot.ft_placements
    return {e.joint: p for e, p in zip(robot.ft_elements, placements, strict=True)}


class _Builder:
    """Walks the links depth first, so that every sub-tree is contiguous in v."""

    def __init__(self, urdf: Urdf, cuts: Mapping[str, pin.SE3], leaves: Sequence[Leaf]):
        self.model = pin.Model()
        self.urdf = urdf
        self.cuts = cuts
        self.leaves = leaves
        self.frame_ids: dict[str, int] = {}
        self.joint_ids: dict[str, int] = {}
        self.leaf_ids: dict[str, int] = {}
        self.signs: dict[str, float] = {}

    def grow(self, root: str) -> None:
        free = pin.JointModelFreeFlyer()
        base = self.model.addJoint(0, free, pin.SE3.Identity(), "root_joint")
        self._visit(root, None, base, pin.SE3.Identity())

    def _visit(self, link: str, via: Joint | None, body: int, placement: pin.SE3) -> None:
        """Add a link that sits at ``placement`` in the frame of joint ``body``."""
        inertia = self.urdf.links[link].inertia
        if inertia is not None:
            self.model.appendBodyToJoint(body, inertia, placement)
        frame = pin.Frame(link, body, 0, placement, pin.FrameType.BODY)
        self.frame_ids[link] = self.model.addFrame(frame)
        for name, where, offset in self.leaves:
            if where == link:
                self._add_leaf(name, body, placement * offset)
        for joint in self.urdf.edges[link]:
            if joint is not via:
                self._cross(joint, link, body, placement)

    def _add_leaf(self, name: str, body: int, placement: pin.SE3) -> None:
        free = pin.JointModelFreeFlyer()
        self.leaf_ids[name] = self.model.addJoint(body, free, placement, name)

    def _cross(self, joint: Joint, link: str, body: int, placement: pin.SE3) -> None:
        forward = joint.parent == link
        beyond = joint.child if forward else joint.parent
        origin = joint.origin if forward else joint.origin.inverse()
        if joint.moving:
            new, placement = self._add_moving(joint, forward, body, placement)
        elif joint.name in self.cuts:
            new, placement = self._add_cut(joint, forward, body, placement)
        else:
            new, placement = body, placement * origin
        self._visit(beyond, joint, new, placement)

    def _add_moving(
        self, joint: Joint, forward: bool, body: int, placement: pin.SE3
    ) -> tuple[int, pin.SE3]:
        """Return the new joint and the placement of the link beyond it.

        child = parent * origin * motion(q). Walked backwards, the joint sits at the
        child, moves about the negated axis, and carries the parent at origin^-1.
        """
        axis = joint.axis if forward else -joint.axis
        at = placement * joint.origin if forward else placement
        new = self.model.addJoint(body, _joint_model(joint.type, axis), at, joint.name)
        self.joint_ids[joint.name] = new
        return new, pin.SE3.Identity() if forward else joint.origin.inverse()

    def _add_cut(
        self, joint: Joint, forward: bool, body: int, placement: pin.SE3
    ) -> tuple[int, pin.SE3]:
        origin = joint.origin if forward else joint.origin.inverse()
        parent_m_sensor = self.cuts[joint.name]
        near_m_sensor = parent_m_sensor if forward else origin * parent_m_sensor
        free = pin.JointModelFreeFlyer()
        new = self.model.addJoint(body, free, placement * near_m_sensor, joint.name)
        self.joint_ids[joint.name] = new
        self.signs[joint.name] = 1.0 if forward else -1.0
        return new, near_m_sensor.inverse() * origin

    def finish(self, robot: Robot, root: str, cut: bool) -> TreeModel:
        model = self.model
        joints = [model.joints[self.joint_ids[name]] for name in robot.joints]
        names = [element.joint for element in robot.ft_elements] if cut else []
        cuts = [model.joints[self.joint_ids[name]] for name in names]
        leaf_v = {name: _six(model.joints[i].idx_v) for name, i in self.leaf_ids.items()}
        return TreeModel(
            model=model,
            root=root,
            joint_q=np.array([joint.idx_q for joint in joints]),
            joint_v=np.array([joint.idx_v for joint in joints]),
            cut_v=np.array([_six(joint.idx_v) for joint in cuts], dtype=int).reshape(-1, 6),
            cut_q=np.array([joint.idx_q for joint in cuts], dtype=int),
            cut_sign=np.array([self.signs[name] for name in names]),
            leaf_v=leaf_v,
            frame_ids=self.frame_ids,
            neutral=pin.neutral(model),
        )


def _six(start: int) -> np.ndarray:
    return np.arange(start, start + 6)


def _joint_model(kind: str, axis: np.ndarray) -> pin.JointModel:
    """Aligned joints are faster; a continuous joint keeps one plain angle in q."""
    prismatic = kind == "prismatic"
    aligned = (
        (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ)
        if prismatic
        else (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)
    )
    for unit, model in zip(np.eye(3), aligned, strict=True):
        if np.array_equal(axis, unit):
            return model()
    free = pin.JointModelPrismaticUnaligned if prismatic else pin.JointModelRevoluteUnaligned
    return free(axis)
