"""The table of offsets."""

from dashboard.offsets import offset_table

OFFSET = {"l_arm_ft": [1.24, -0.5, 2.0, 0.01, 0.02, 0.034], "r_arm_ft": [0.0] * 6}
TARE = {"date": "2026-01-01T00:00:00Z", "stance": "l_sole", "samples": 500, "error": ""}


def test_offset_and_largest_spread_are_shown_per_sensor():
    spread = {"l_arm_ft": [0.2, 0.31, 0.1, 0.01, 0.004, 0.002]}
    shown = offset_table({"offset": OFFSET, "tare": TARE | {"spread": spread}})
    for text in (">1.2 -0.5 2.0<", ">0.01 0.02 0.03<", ">0.31<", ">0.010<", ">r_arm_ft<"):
        assert text in shown
    assert "on l_sole, 500 samples" in shown


def test_a_file_that_could_not_be_written_is_said_and_harmless():
    shown = offset_table({"offset": OFFSET, "tare": TARE | {"error": "not stored: <b>"}})
    assert "not stored: &lt;b&gt;" in shown


def test_without_a_tare_or_an_observer_that_is_what_is_shown():
    untared = {"offset": OFFSET, "tare": {"date": "", "spread": {}}}
    assert "Not tared." in offset_table(untared)
    assert offset_table({}) == ""
