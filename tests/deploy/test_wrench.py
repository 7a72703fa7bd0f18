"""``wrenchbus wrench``: what is asked, and how the answer is shown."""

import pytest

from tests.deploy.answering import answering

TOLD = {
    "of": "joint:l_elbow",
    "frame": "root_link",
    "axes": "chest",
    "point": [0.0, 0.0, 0.1],
    "force": [1.0, -2.0, 3.456],
    "moment": [0.1, 0.2, -0.3],
    "covariance": [[(0.01 * (i + 1) ** 2) * (i == j) for j in range(6)] for i in range(6)],
    "decided": True,
    "undecided": [],
    "stamp": 7,
    "valid": True,
    "reason": "",
}
OPEN = {"decided": False, "undecided": [[0.0, 0.0, 1.0, 0.0, 0.05, 0.0]]}
LOST = {"valid": False, "reason": "no data from l_arm_ft"}


@pytest.fixture
def observer(toy_bus):
    """A torque observer that notes what is asked of it, and says what it is told to."""
    asked, says = [], dict(TOLD)

    def told(**request):
        asked.append(request)
        return says

    with answering(toy_bus, "torque_observer", {"/torque_observer/rpc:i": {"wrench": told}}):
        yield asked, says


def test_each_number_is_shown_with_its_standard_deviation(verb, observer):
    asked, _ = observer
    words = "joint:l_elbow", "--frame", "root_link", "--axes", "chest", "--point", "0,0,0.1"
    assert verb("wrench", *words).out.splitlines() == [
        "joint:l_elbow about (0, 0, 0.1) m in root_link, axes of chest",
        "  force [N]: 1.00 ± 0.10  -2.00 ± 0.20  3.46 ± 0.30",
        "  moment [N m]: 0.100 ± 0.400  0.200 ± 0.500  -0.300 ± 0.600",
    ]
    request = {"of": "joint:l_elbow", "frame": "root_link", "axes": "chest"}
    assert asked == [{**request, "point": [0.0, 0.0, 0.1]}]
    assert verb("wrench", "joint:l_elbow", "--json").documents == [TOLD]


def test_what_is_invalid_or_undecided_is_marked(verb, observer):
    _, says = observer
    says.update(**OPEN, **LOST)
    shown = verb("wrench", "contact:l_hand").out.splitlines()
    assert shown[1] == "INVALID: no data from l_arm_ft"
    assert shown[4].startswith("UNDECIDED: this is the smallest that explains the sensors")
    assert shown[-1].split() == ["0.000", "0.000", "1.000", "0.000", "0.050", "0.000"]
