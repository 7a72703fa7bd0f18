import numpy as np

from dashboard.bars import torque_bars
from dashboard.html import line, note
from dashboard.input_rows import input_rows, input_table
from dashboard.port_rows import Written, port_rows, port_table

EVIL = '<img src=x onerror="alert(1)">'
OWNER = {"service": "torque_observer", "host": "here", "pid": 1}


def output(name="/icub/torques:o", **changes):
    port = {"name": name, "direction": "output", "owner": OWNER, "nominal_hz": 1000.0}
    told = {"sources": [], "hz": 999.0, "statistics": {"written": 10}, "wanted_hz": 1000.0}
    return port | told | changes


def reader(lost, source="/icub/torques:o"):
    return output("/x:i", direction="input", sources=[source], statistics={"lost": lost})


def test_text_from_the_bus_is_escaped_everywhere():
    bars = torque_bars((EVIL,), np.ones(1), np.ones(1, dtype=bool), np.ones(1))
    table = port_table(port_rows([output(EVIL)], Written(), 0.0), {})
    inputs = input_table(input_rows([reader(0, EVIL)]))
    for html in (line("status", EVIL, "red"), note("last", EVIL), bars, table, inputs):
        assert "<img" not in html and "&lt;img" in html


def test_bar_of_a_negative_torque_ends_at_the_middle():
    html = torque_bars(("elbow",), np.array([-5.0]), np.array([True]), np.array([10.0]))
    assert "left:25.0%;width:25.0%" in html and ">-5.0<" in html


def test_bar_never_leaves_its_limits_and_changes_colour_there():
    within = torque_bars(("elbow",), np.array([9.9]), np.array([True]), np.array([10.0]))
    beyond = torque_bars(("elbow",), np.array([99.0]), np.array([True]), np.array([10.0]))
    assert "left:50.0%;width:50.0%" in beyond
    assert "#f85149" in beyond and "#f85149" not in within


def test_invalid_torque_has_no_bar_and_no_number():
    html = torque_bars(("elbow",), np.array([0.0]), np.array([False]), np.array([10.0]))
    assert ">--<" in html and "+0.0" not in html


def test_port_at_its_rate_is_alive():
    (row,) = port_rows([output()], Written(), 0.0)
    assert (row.state, row.hz, row.nominal) == ("alive", 999.0, 1000.0)


def test_slow_silent_idle_and_unanswering_ports_are_told_apart():
    ports = [output(hz=500.0), output(hz=0.0), output(hz=0.0, wanted_hz=0.0), output(error="no")]
    states = [row.state for row in port_rows(ports, Written(), 0.0)]
    assert states == ["slow", "silent", "idle", "no answer"]


def test_port_whose_readers_are_content_with_less_is_alive_at_that():
    (row,) = port_rows([output(hz=249.0, wanted_hz=250.0)], Written(), 0.0)
    assert row.state == "alive"


def test_age_grows_while_the_counter_of_a_port_stands():
    written = Written()
    assert port_rows([output()], written, 10.0)[0].age == 0.0
    assert port_rows([output()], written, 13.0)[0].age == 3.0
    assert port_rows([output(statistics={"written": 11})], written, 14.0)[0].age == 0.0


def test_losses_of_all_readers_are_counted_at_the_port_that_they_read():
    ports = [output(), reader(2), reader(3), reader(7, "/icub/other:o")]
    (row,) = port_rows(ports, Written(), 0.0)
    assert row.lost == 5


def test_input_tells_its_losses_on_the_wire_and_its_drops_in_the_queue():
    counts = {"lost": 4, "dropped": 5, "refused": 6, "foreign": 1}
    port = reader(0) | {"statistics": counts, "queue": {"depth": 64, "mode": "fifo"}}
    (row,) = input_rows([port | {"fresh": True}, output()])
    assert (row.lost, row.dropped, row.refused, row.queue) == (4, 5, 7, "64")
    html = input_table([row])
    assert all(f">{number}<" in html for number in (4, 5, 7, 64))


def test_fresh_stale_waiting_and_unanswering_inputs_are_told_apart():
    event = reader(0) | {"nominal_hz": 0.0}
    ports = [reader(0) | {"fresh": True}, reader(0), event, reader(0) | {"error": "stopped"}]
    assert [row.state for row in input_rows(ports)] == ["fresh", "stale", "waiting", "no answer"]
