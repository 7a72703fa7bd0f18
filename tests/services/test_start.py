"""What the processes load when they start: on two cores they all wait for each other."""

import subprocess
import sys

CHAIN = (
    "robot_sim.service",
    "services.sensor_server.service",
    "services.base_estimator.service",
    "services.torque_observer.service",
    "services.gravity_compensator.service",
)


def test_the_control_chain_starts_without_scipy():
    code = f"import sys, {', '.join(CHAIN)}; print({{'scipy', 'matplotlib'}} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
