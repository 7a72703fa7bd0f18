"""Raw force/torque readings become what the parent exerts on the child, sensor by sensor."""

import warnings

import numpy as np
import pinocchio as pin

from robot_model import build_tree
from robot_model.ft_convention import from_wrenchbus, raw_to_wrenchbus, to_wrenchbus

with warnings.catch_warnings():
    # SWIG's types warn at import; where warnings are errors, the import would crash.
    warnings.simplefilter("ignore", DeprecationWarning)
    import idyntree.swig as idyntree


def test_every_sensor_of_icub_turns_the_sign_and_keeps_the_frame(icub):
    elements = [element.frame for element in icub.ft_elements]
    assert elements == ["child", "child", "sensor", "sensor", "sensor", "sensor"]
    for matrix in raw_to_wrenchbus(icub):
        np.testing.assert_allclose(matrix, -np.eye(6), atol=1e-12)


def test_conversion_goes_both_ways_also_for_many_samples(robot, random):
    raw = random.normal(size=(5, len(robot.ft_sensors), 6))
    readings = to_wrenchbus(robot, raw)
    np.testing.assert_allclose(from_wrenchbus(robot, readings), raw, atol=1e-12)
    np.testing.assert_allclose(to_wrenchbus(robot, raw[2]), readings[2], atol=1e-12)


def test_a_sensor_with_axes_of_its_own_is_turned_into_its_urdf_frame(tiny, random):
    """A force at a known point on the forearm, by hand."""
    force, point = random.normal(size=(2, 3))  # in the axes and about the origin of `fore`
    moment = np.cross(point, force)
    spin, shift = pin.rpy.rpyToMatrix(0.0, 0.0, 0.7), np.array([0.005, 0.0, 0.0])
    raw = np.r_[spin.T @ force, spin.T @ (moment - np.cross(shift, force))]
    turn, origin = pin.rpy.rpyToMatrix(0.2, -0.3, 0.4), np.array([0.01, 0.02, 0.03])
    expected = np.r_[turn.T @ force, turn.T @ (moment - np.cross(origin, force))]
    np.testing.assert_allclose(to_wrenchbus(tiny, raw[None])[0], expected, atol=1e-12)


def test_readings_equal_idyntrees_for_each_sensor(icub, random):
    """The peer reads the same URDF elements; a random motion excites every component."""
    estimator = idyntree.ExtWrenchesAndJointTorquesEstimator()
    loader = idyntree.ModelLoader()
    assert loader.loadModelFromFile(str(icub.urdf.path)) and estimator.setModel(loader.model())
    tree = build_tree(icub, "root_link", cut=True)
    tree.model.gravity = pin.Motion.Zero()
    data = tree.model.createData()
    for _ in range(20):
        q, dq, ddq = random.normal(size=(3, icub.n))
        gyro, acceleration, spin = random.normal(size=(3, 3))
        raw = expected_by_idyntree(estimator, icub, (q, dq, ddq), (acceleration, gyro, spin))
        torque = pin.rnea(
            tree.model,
            data,
            tree.configuration(q),
            tree.velocity(dq, np.r_[0.0, 0.0, 0.0, gyro]),
            tree.velocity(ddq, np.r_[acceleration, spin]),
        )
        readings = tree.cut_sign[:, None] * torque[tree.cut_v]
        np.testing.assert_allclose(to_wrenchbus(icub, raw), readings, atol=1e-9)


def expected_by_idyntree(estimator, robot, joint_motion, base_motion):
    """Raw readings (k, 6) when only root_link is touched."""
    model, sensors = estimator.model(), estimator.sensors()
    vectors = [idyntree.JointPosDoubleArray(model)]
    vectors += [idyntree.JointDOFsDoubleArray(model) for _ in range(2)]
    for vector, values in zip(vectors, joint_motion, strict=True):
        for joint, value in zip(robot.joints, values, strict=True):
            index = model.getJoint(model.getJointIndex(joint)).getDOFsOffset()
            vector.setVal(index, float(value))
    base = [idyntree.Vector3.FromPython(values) for values in base_motion]
    root = model.getFrameIndex("root_link")
    assert estimator.updateKinematicsFromFloatingBase(*vectors, root, *base)
    unknown, contact = idyntree.LinkUnknownWrenchContacts(model), idyntree.UnknownWrenchContact()
    contact.unknownType, contact.contactPoint = idyntree.FULL_WRENCH, idyntree.Position.Zero()
    unknown.addNewContactForLink(model.getLinkIndex("root_link"), contact)
    measured = idyntree.SensorsMeasurements(sensors)
    contacts, torques = idyntree.LinkContactWrenches(model), idyntree.JointDOFsDoubleArray(model)
    assert estimator.computeExpectedFTSensorsMeasurements(unknown, measured, contacts, torques)
    kind, readings = idyntree.SIX_AXIS_FORCE_TORQUE, {}
    for index in range(sensors.getNrOfSensors(kind)):
        wrench = idyntree.Wrench()
        measured.getMeasurement(kind, index, wrench)
        readings[sensors.getSensor(kind, index).getName()] = wrench.toNumPy()
    return np.array([readings[name] for name in robot.ft_sensors])
