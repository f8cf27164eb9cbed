"""Projected markers against a pinhole model by numpy, and their visibility."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from scipy.spatial.transform import Rotation

import cdpr

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
ROUND_OFF = 1e-12  # of the pixel, which has about 1000 px
LENS = {"focal": (900.0, 850.0), "center": (310.0, 250.0), "size": (640, 480)}
DOWN = Rotation.from_euler("x", np.pi)  # looks down, x as in the world


def run(sensor, **overrides):
    common = {"simulation.duration": 0.2, "initial.orientation": {"rpy": [0.1, -0.2, 0.3]}}
    return cdpr.simulate(CAROCA, overrides={**common, "sensors": [{"type": "markers", **sensor}], **overrides})


def projected(points):
    """Pixels (k, 2) of points (k, 3) in the camera's axes, by the matrix of intrinsics."""
    matrix = np.array([[900.0, 0.0, 310.0], [0.0, 850.0, 250.0], [0.0, 0.0, 1.0]])
    scaled = points @ matrix.T
    return scaled[:, :2] / scaled[:, 2:]


def quaternion(rotation):
    return rotation.as_quat(scalar_first=True).tolist()


def test_a_camera_in_the_hall_sees_markers_on_the_platform():
    camera, place = DOWN * Rotation.from_rotvec([0.05, 0.02, 0.4]), np.array([0.1, -0.1, 4.0])
    markers = np.array([[0.3, 0.2, 0.9], [-0.2, 0.4, 0.8], [0.0, 0.0, 0.85]])
    sensor = {"position": place.tolist(), "attitude": quaternion(camera), "markers": markers.tolist(), **LENS}
    seen = run(sensor)
    for k in range(0, len(seen.time), 20):
        body = Rotation.from_quat(seen.orientation[k], scalar_first=True)
        world = seen.position[k] + body.apply(markers)
        expected = projected(camera.inv().apply(world - place))
        assert seen["markers_pixel"][k] == pytest.approx(expected.ravel(), rel=ROUND_OFF)
        assert seen["markers_seen"][k].tolist() == [1.0, 1.0, 1.0]


def test_a_camera_on_the_platform_sees_markers_in_the_hall():
    camera, place = DOWN * Rotation.from_rotvec([0.1, 0.0, 0.2]), np.array([0.05, 0.1, -0.4])
    markers = np.array([[0.1, 0.2, 0.0], [-0.1, 0.0, 0.02]])
    sensor = {"on": "platform", "position": place.tolist(), "attitude": quaternion(camera), "markers": markers.tolist()}
    seen = run({**sensor, **LENS})
    for k in range(0, len(seen.time), 20):
        body = Rotation.from_quat(seen.orientation[k], scalar_first=True)
        eye, axes = seen.position[k] + body.apply(place), body * camera
        expected = projected(axes.inv().apply(markers - eye))
        inside = ((expected >= 0.0) & (expected < [640, 480])).all(axis=1)
        assert np.array_equal(seen["markers_seen"][k] == 1.0, inside)
        assert seen["markers_pixel"][k].reshape(-1, 2)[inside] == pytest.approx(expected[inside], rel=ROUND_OFF)
    assert seen["markers_seen"].any()


def still(sensor, **overrides):
    seen = run(sensor, **{"simulation.duration": 0.01, "initial.orientation": {"rpy": [0, 0, 0]}, **overrides})
    return np.atleast_1d(seen["markers_seen"][-1]).tolist(), seen["markers_pixel"][-1].reshape(-1, 2)


def test_markers_behind_beside_and_hidden_are_not_seen():
    above = {"position": [0.0, 0.0, 5.0], "attitude": quaternion(DOWN), **LENS}
    seen, pixel = still({**above, "markers": [[0.0, 0.0, 6.0], [4.0, 0.0, 0.0], [0.0, 0.0, 1.0]]})
    assert seen == [0.0, 0.0, 1.0]
    assert pixel[:2].tolist() == [[310.0, 250.0], [310.0, 250.0]]  # as at the start
    lid = [{"name": "lid", "box": [0.2, 0.2, 0.1], "position": [0.0, 0.0, 4.0]}]
    seen, _ = still({**above, "markers": [[0.0, 0.0, 1.0], [0.8, 0.0, 1.0]]}, **{"world.obstacles": lid})
    assert seen == [0.0, 1.0]


def test_the_platform_hides_its_far_side_only():
    above = {"position": [0.0, 0.0, 5.0], "attitude": quaternion(DOWN), **LENS}
    shape = {"robot.platform.shape": {"box": [0.4, 0.4, 0.4]}}
    seen, _ = still({**above, "markers": [[0.0, 0.0, 0.2], [0.0, 0.0, -0.2], [0.19, 0.19, 0.2]]}, **shape)
    assert seen == [1.0, 0.0, 1.0]
    inside = {"on": "platform", "position": [0.0, 0.0, 0.0], "attitude": quaternion(DOWN), **LENS}
    seen, _ = still({**inside, "markers": [[0.0, 0.0, 0.0]]}, **shape)
    assert seen == [1.0]


def test_noise_does_not_change_the_flag():
    above = {"position": [0.0, 0.0, 5.0], "attitude": quaternion(DOWN), **LENS}
    noisy = run({**above, "markers": [[0.0, 0.0, 1.0]], "pixel": {"noise": 0.5, "resolution": 1.0}})
    assert set(noisy["markers_seen"].ravel()) == {1.0}
    assert np.array_equal(noisy["markers_pixel"], np.rint(noisy["markers_pixel"]))
    assert len(set(noisy["markers_pixel"][:, 0])) > 1


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"attitude": [1, 1, 0, 0]}, "attitude: expected a unit quaternion"),
        ({"markers": []}, r"sensors\[0\].markers: expected 1 or more items"),
        (
            {"markers": [[np.nan, 0, 0]]},
            r"^overrides: sensors\[0\].markers\[0\]\[0\]: expected a finite number \(m\), got nan$",
        ),
        ({"focal": [0, 1]}, r"sensors\[0\].focal\[0\]: must be greater than 0 \(px\), got 0"),
        ({"focal": [1e-300, 1]}, r"focal: expected at least 0.64 px and 0.48 px"),
        ({"center": [0, -1e300]}, r"center: expected at most 640000 px and 480000 px in size"),
        ({"size": [0, 1]}, r"sensors\[0\].size\[0\]: must be at least 1"),
        ({"markers": [[0, 0]]}, r"sensors\[0\].markers\[0\]: expected 3 numbers"),
        ({"position": None}, r"sensors\[0\].position: "),
        ({"pixle": 1}, r"sensors\[0\].pixle: unknown key"),
    ],
)
def test_invalid_cameras_are_rejected(change, text):
    with pytest.raises(cdpr.CdprError, match=text):
        run({"position": [0, 0, 5], "markers": [[0, 0, 0]], **change})
