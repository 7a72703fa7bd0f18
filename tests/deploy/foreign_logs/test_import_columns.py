"""``wrenchbus log import-csv`` and ``import-npz``."""

import numpy as np
import pytest
import yaml

from deploy.main import run
from tests.deploy.foreign_logs.importing import convert, frames, make_arrays

TABLE_MAP = {
    "time": {"column": "time", "unit": "ms"},
    "streams": [
        {"columns": ["elbow"], "q": {"joints": ["l_elbow"], "unit": "rad"}},
        {
            "columns": ["fx", "fy", "fz", "mx", "my", "mz"],
            "ft": {"sensor": "l_arm_ft", "convention": "wrenchbus"},
        },
    ],
}


def write_table(tmp_path, rows):
    table, chosen = tmp_path / "log.csv", tmp_path / "map.yaml"
    table.write_text("time,elbow,fx,fy,fz,mx,my,mz\n" + "\n".join(rows) + "\n")
    chosen.write_text(yaml.safe_dump(TABLE_MAP))
    return table, chosen


def test_a_table_is_imported_and_empty_cells_are_no_samples(robot, tmp_path, capsys):
    rows = [f"{10 * k},{0.1 * k},{k},0,0,0,0,0" for k in range(20)]
    rows[5] = "50,0.5,,,,,,"  # bridged
    rows[7] = "70,zero,7,0,0,0,0,0"
    rows[9] = "90"
    table, chosen = write_table(tmp_path, rows)
    out = tmp_path / "out.mcap"
    summary, said = convert(capsys, "import-csv", table, "--map", chosen, "-o", out)
    assert f"{table}:9: malformed" in said and f"{table}:11: malformed" in said
    assert summary["lines_left_out"] == 3  # the last one in each of the two streams
    t, read = frames(out, robot)
    elbow, arm = robot.joints.index("l_elbow"), robot.ft_sensors.index("l_arm_ft")
    assert len(read) == 18
    assert read[5].q[elbow] == pytest.approx(0.5) and read[5].ft[arm, 0] == pytest.approx(5.0)


def test_arrays_are_imported_in_the_robots_order(robot, tmp_path, capsys):
    arrays = make_arrays(robot)
    arrays["ft_l_arm_ft"][7, 2] = np.nan
    np.savez(tmp_path / "log.npz", **arrays)
    out = tmp_path / "out.mcap"
    _, said = convert(capsys, "import-npz", tmp_path / "log.npz", "-o", out)
    assert "not a finite number" in said and "ft: never valid: r_arm_ft" in said
    _, read = frames(out, robot)
    assert read[3].q.tolist() == (0.01 * np.arange(robot.n)).tolist()
    assert read[3].imu_valid.all() and read[3].ft[0].tolist() == 6 * [1.0]
    assert read[7].ft_valid[0]  # one sample is bridged


def test_measured_velocities_and_torques_are_kept(robot, tmp_path, capsys):
    arrays = make_arrays(robot)
    shape = arrays["q"].shape
    arrays |= {"dq": np.full(shape, 0.5), "motor_torque": np.full(shape, 2.0)}
    np.savez(tmp_path / "log.npz", **arrays)
    out = tmp_path / "out.mcap"
    convert(capsys, "import-npz", tmp_path / "log.npz", "-o", out)
    _, read = frames(out, robot)
    assert read[3].dq.tolist() == robot.n * [0.5]
    assert read[3].motor_torque.tolist() == robot.n * [2.0]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"stamp": None}, "no array 'stamp'"),
        ({"stamp": np.arange(50.0)}, "stamp: expected (T,) integers [ns], got float64"),
        ({"stamp": np.zeros(50, dtype=int)}, "stamp: expected rising"),
        ({"q": np.zeros((50, 3))}, "q: expected (50, 32) numbers"),
        ({"ft_l_arm": np.zeros((50, 6))}, "did you mean l_arm_ft"),
        ({"joint_names": np.array(["elbow"] * 32)}, "has no joint elbow"),
    ],
)
def test_arrays_that_do_not_fit_are_one_line(change, expected, robot, tmp_path, capsys):
    arrays = make_arrays(robot) | change
    kept = {name: array for name, array in arrays.items() if array is not None}
    np.savez(tmp_path / "log.npz", **kept)
    path, out = str(tmp_path / "log.npz"), tmp_path / "out.mcap"
    assert run(["log", "import-npz", path, "-o", str(out)]) == 2
    shown = capsys.readouterr().err
    assert expected in shown and shown.count("\n") == 1 and not out.exists()
