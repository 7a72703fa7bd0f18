"""docs/recordings.md works as typed: its shell blocks that need no bus are run here."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from robot_model import load_robot
from tests.deploy.recorded import make_recording

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```", re.MULTILINE | re.DOTALL)
WRENCHBUS = f'wrenchbus() {{ "{sys.executable}" -m deploy.main "$@"; }}\n'
PYTHON = f'python() {{ "{sys.executable}" "$@"; }}\n'


def test_the_tour_of_recordings_works_as_typed(tmp_path):
    make_recording(tmp_path / "touch.mcap", load_robot("icub"))
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    blocks = BLOCK.findall((ROOT / "docs" / "recordings.md").read_text())
    scripts = [text for kind, text in blocks if kind == "sh"]
    script = "set -e\n" + WRENCHBUS + PYTHON + "".join(scripts)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        ["bash", "-c", script], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "as expected: it was cut" in done.stdout
    assert {"dump.mcap", "log.mcap", "arrays.mcap"} <= {file.name for file in tmp_path.iterdir()}
    data = np.load(tmp_path / "touch.npz")
    assert "icub/torques:o/torque" in data
