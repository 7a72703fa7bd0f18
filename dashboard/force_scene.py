"""Arrows, needles and hypotheses in the browser."""

import numpy as np
import viser

from .probability_colours import LIKELY, probability_colours
from .touches import Touch

Array = np.ndarray

TOUCH = (255, 60, 0)  # estimated: orange, solid arrows
SUPPORT = (255, 190, 0)
TRUTH = (40, 130, 255)  # true: blue needles with a ball at the point
UNDECIDED = (150, 155, 160)  # grey: the data leave open what it is
HYPOTHESES = 20  # drawn at most

_NOWHERE = np.zeros((1, 2, 3), dtype=np.float32)


class ForceScene:
    """Everything that pushes the robot, as estimated and as it is."""

    def __init__(self, scene: viser.SceneApi):
        self._touches = _arrows(scene, "/estimate/touches", TOUCH, 0.008)
        self._supports = _arrows(scene, "/estimate/supports", SUPPORT, 0.008)
        self._undecided = _arrows(scene, "/estimate/undecided", UNDECIDED, 0.008)
        self._open = scene.add_label("/estimate/undecided_label", "undecided", visible=False)
        self._lines = scene.add_line_segments(
            "/estimate/lines", _NOWHERE, tuple(LIKELY), thickness=0.004, visible=False
        )
        self._best = _arrows(scene, "/estimate/hypothesis", tuple(LIKELY), 0.006)
        self._needles = scene.add_line_segments(
            "/truth/needles", _NOWHERE, TRUTH, thickness=0.008, visible=False
        )
        self._balls = _points(scene, "/truth/points", 0.022)
        self._hypotheses = _points(scene, "/estimate/hypotheses", 0.03)
        self._label = scene.add_label("/estimate/best", "", visible=False, font_screen_scale=1.1)

    def show_estimate(self, touches: Array, supports: Array, undecided: Array) -> None:
        """Draw arrows, (m, 2, 3) [m], tip at the point of action."""
        _set_points(self._touches, touches)
        _set_points(self._supports, supports)
        _set_points(self._undecided, undecided)
        self._open.visible = len(undecided) > 0
        if len(undecided):
            self._open.position = undecided[0, 0]

    def show_lines(self, lines: Array) -> None:
        """Draw lines of action, (m, 2, 3) [m]."""
        _set_points(self._lines, lines)

    def show_truth(self, needles: Array) -> None:
        """Draw needles, (m, 2, 3) [m], ball at the point of action."""
        _set_points(self._needles, needles)
        _set_points(self._balls, needles[:, 1])
        if len(needles):
            self._balls.colors = np.array(TRUTH, dtype=np.uint8)

    def show_hypotheses(self, touches: list[Touch], scale: float, dots: bool) -> None:
        """Draw the best hypothesis with its force and its name, and all as ``dots``."""
        shown = touches[:HYPOTHESES]
        places = [touch.point for touch in shown if dots]
        _set_points(self._hypotheses, np.array(places, dtype=np.float32).reshape(-1, 3))
        self._label.visible = bool(shown)
        if not shown:
            _set_points(self._best, _NOWHERE[:0])
            return
        best = shown[0]
        self._hypotheses.colors = probability_colours([touch.probability for touch in shown])
        tail = best.point - scale * best.force
        _set_points(self._best, np.array([[tail, best.point]], dtype=np.float32))
        self._label.position = tail
        self._label.text = best.label


def _arrows(
    scene: viser.SceneApi, name: str, colour: tuple[int, ...], radius: float
) -> viser.ArrowsHandle:
    return scene.add_arrows(
        name,
        _NOWHERE,
        np.array(colour, dtype=np.uint8),
        shaft_radius=radius,
        head_radius=2.2 * radius,
        head_length=4.0 * radius,
        visible=False,
    )


def _points(scene: viser.SceneApi, name: str, size: float) -> viser.PointCloudHandle:
    return scene.add_point_cloud(
        name,
        _NOWHERE[0, :1],
        TRUTH,
        point_size=size,
        point_shape="circle",
        precision="float32",
        visible=False,
    )


def _set_points(
    handle: viser.ArrowsHandle | viser.LineSegmentsHandle | viser.PointCloudHandle, points: Array
) -> None:
    """Empty sets are hidden instead of sent."""
    handle.visible = len(points) > 0
    if len(points):
        handle.points = points
