"""Calibrations of the contact detector, in one file per robot and support."""

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from estimation.contact.contact_calibration import ContactCalibration
from estimation.contact.row_layout import RowLayout
from robot_model import Robot
from robot_model.dated_store import DatedFile, DatedRecord, DatedStore, StoreError, state_folder

Deviation = Annotated[float, Field(ge=0.0)]
Deviations = Annotated[list[Deviation], Field(min_length=6, max_length=6)]  # N, N m


class CalibrationRecord(DatedRecord):
    """One calibration: standard deviations beyond the sensors' noise, and thresholds."""

    support: str
    samples: int = Field(ge=1)
    base: Deviations  # of the sum of all forces
    torque: dict[str, Deviation]  # N m, by joint
    ft: dict[str, Deviations]  # by sensor, in its frame
    threshold: dict[str, Deviation]  # standard deviations, by limb
    body: Deviation  # likewise, of the whole body

    def check(self, robot: Robot) -> None:
        """Refuse a calibration of another robot, model or set of sensors."""
        super().check(robot)
        limbs = {subtree.name for subtree in robot.subtrees}
        known = [set(robot.joints), set(robot.ft_sensors), limbs]
        if [set(self.torque), set(self.ft), set(self.threshold)] != known:
            raise StoreError(
                f"the calibration of {self.date} is of other joints, sensors or limbs than"
                f" {robot.name} has"
            )


class CalibrationFile(DatedFile):
    """The whole file, oldest calibration first."""

    version: Literal[2] = 2  # 1: torque came on top of friction that is expected anyhow
    calibrations: list[CalibrationRecord] = []


class CalibrationStore(DatedStore[CalibrationFile, CalibrationRecord]):
    """The calibrations of one robot on one support; the file bears both names."""

    def __init__(self, robot: Robot, support: str, kept: int, folder: Path | None = None):
        path = (folder or state_folder("contact_calibrations")) / f"{robot.name}-{support}.json"
        super().__init__(robot, kept, path, CalibrationFile, "calibrations", "calibration")


def record_of(
    calibration: ContactCalibration, layout: RowLayout, date: str, support: str
) -> CalibrationRecord:
    """Return a calibration as the file has it."""
    robot, tree = layout.robot, layout.tree
    deviation = np.sqrt(calibration.floor)
    limbs = [subtree.name for subtree in robot.subtrees]
    return CalibrationRecord(
        date=date,
        robot=robot.name,
        model=robot.model_hash,
        support=support,
        samples=calibration.samples,
        base=deviation[:6].tolist(),
        torque=dict(zip(robot.joints, deviation[tree.joint_v].tolist(), strict=True)),
        ft=dict(zip(robot.ft_sensors, deviation[tree.cut_v].tolist(), strict=True)),
        threshold=dict(zip(limbs, calibration.threshold.tolist(), strict=True)),
        body=calibration.body_threshold,
    )


def calibration_of(record: CalibrationRecord, layout: RowLayout) -> ContactCalibration:
    """Return a stored calibration as the detector takes it."""
    robot, tree = layout.robot, layout.tree
    deviation = np.zeros(layout.model.nv)
    deviation[:6] = record.base
    deviation[tree.joint_v] = [record.torque[joint] for joint in robot.joints]
    deviation[tree.cut_v] = [record.ft[sensor] for sensor in robot.ft_sensors]
    threshold = np.array([record.threshold[subtree.name] for subtree in robot.subtrees])
    return ContactCalibration(np.square(deviation), threshold, record.body, record.samples)
