"""What an estimate is written as: arrays over time in one npz (docs/estimate.md)."""

import zipfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from deploy.errors import CommandError
from deploy.estimate.run import Estimation
from deploy.recordings.columns import save_into
from estimation.contact_set import numbered
from estimation.offline.log_contacts import RESIDUALS, ContactLog

Array = np.ndarray


def arrays_of(estimation: Estimation) -> dict[str, Array]:
    """Return the arrays by name."""
    found, robot = estimation.found, estimation.robot
    arrays = {
        "stamp": estimation.log.stamp,
        "joint_names": np.array(robot.joints),
        "joint_torque": found.torque,
        "joint_torque_std": found.torque_std,
        "valid_joint_torque": found.torque_valid,
    }
    arrays |= _wrenches(estimation)
    for index, sensor in enumerate(robot.ft_sensors):
        arrays[f"ft_predicted_{sensor}"] = found.predicted[:, index]
    if estimation.contacts is not None:
        arrays |= _residuals(estimation.contacts)
    return arrays


def _wrenches(estimation: Estimation) -> dict[str, Array]:
    found, arrays = estimation.found, {}
    for index, name in enumerate(numbered(c.frame for c in estimation.observer.contacts)):
        arrays[f"wrench_{name}"] = found.wrench[:, index]
        arrays[f"wrench_{name}_std"] = found.wrench_std[:, index]
        valid = found.wrench_valid[:, index]
        arrays[f"valid_wrench_{name}"] = np.repeat(valid[:, None], 6, axis=1)
    return arrays


def _residuals(contacts: ContactLog) -> dict[str, Array]:
    arrays = {}
    for name in RESIDUALS:
        arrays[f"residual_{name}"], arrays[f"valid_residual_{name}"] = contacts.residual(name)
    places = contacts.hypotheses()
    arrays["none_probability"] = places.pop("none_probability")
    arrays |= {f"contact_{name}": table for name, table in places.items()}
    return arrays | {"valid_contact": contacts.valid}


def write_npz(arrays: Mapping[str, Array], out: Path) -> None:
    """Write the arrays; CommandError when that is not possible."""
    try:
        with zipfile.ZipFile(out, "w") as archive:
            for name, array in arrays.items():
                save_into(archive, name, partial(npy.write_array, array=array))
    except OSError as error:
        raise CommandError(f"cannot write {out}: {error.strerror or error}") from None
