"""Pages that work as typed: their shell blocks that need no bus are run here."""

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


def run_page(name: str, folder: Path) -> str:
    """Run the shell blocks of a page in a folder; return what they print."""
    (folder / "docs").symlink_to(ROOT / "docs")
    blocks = BLOCK.findall((ROOT / "docs" / name).read_text())
    scripts = [text for kind, text in blocks if kind == "sh"]
    script = "set -e\n" + WRENCHBUS + PYTHON + "".join(scripts)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        ["bash", "-c", script], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_tour_of_recordings_works_as_typed(tmp_path):
    make_recording(tmp_path / "touch.mcap", load_robot("icub"))
    told = run_page("recordings.md", tmp_path)
    assert "as expected: it was cut" in told
    assert {"dump.mcap", "log.mcap", "arrays.mcap"} <= {file.name for file in tmp_path.iterdir()}
    data = np.load(tmp_path / "touch.npz")
    assert "icub/torques:o/torque" in data


def test_the_example_of_estimate_works_as_typed(tmp_path):
    assert "written: found.npz: 500 samples" in run_page("estimate.md", tmp_path)
    found = np.load(tmp_path / "found.npz")
    elbow = found["joint_names"].tolist().index("l_elbow")
    known = found["valid_joint_torque"][:, elbow]
    assert known.sum() == 500 - 48 and (found["joint_torque"][known, elbow] != 0.0).all()
