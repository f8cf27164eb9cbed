"""Sensors and estimates in reports, scenes and logs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from mcap.reader import make_reader

import cdpr
from cdpr.base.columns import GROUPS
from cdpr.log.ros2 import decode
from cdpr.log.run import Run
from cdpr.ui.live.type_hash import type_hash
from cdpr.ui.report.pages.run import drawings
from cdpr.ui.report.plots import sensors as plots
from cdpr.ui.report.plots.truths import errors, measured_truth

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
ROUND_OFF = 1e-9  # lengths, pixels and forces up to 1e3
SINGLE = 1e-6  # m: float32 at some metres
LATE = {"period": 0.004, "delay": 0.003}
CAMERA = {"position": [0.0, 0.0, 3.2], "attitude": [0.0, 1.0, 0.0, 0.0]}
ALL = [
    {"type": "pose", **LATE},
    {"type": "twist", **LATE},
    {"type": "encoders", **LATE},
    {"type": "tension", **LATE},
    {"type": "imu", "point": [0.1, 0.0, 0.1], **LATE},
    {"type": "receiver", "antenna": [0.0, 0.2, 0.4], **LATE},
    {"type": "range", "direction": [0.0, 0.0, -2.0], **LATE},
    {"type": "scan", "rays": 5, "reach": 3.0, **LATE},
    {"type": "markers", **CAMERA, "markers": [[0.1, 0.0, 0.2], [0.0, 0.3, 0.2]], **LATE},
]
WORLD = {"world.obstacles": [{"name": "floor", "box": [8.0, 8.0, 0.2], "position": [0.0, 0.0, -0.5]}]}
SHORT = {"simulation.duration": 0.1, "sensors": ALL, **WORLD}
HASHES = {  # of ROS 2 Jazzy
    "sensor_msgs/Imu": "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
    "sensor_msgs/Range": "RIHS01_b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a",
    "sensor_msgs/LaserScan": "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
}


@pytest.fixture(scope="module")
def run() -> Run:
    return cdpr.simulate(CAROCA, overrides=SHORT)


@pytest.mark.parametrize("sensor", [each["type"] for each in ALL])
def test_exact_sensors_have_no_error(run: Run, sensor: str) -> None:
    measuring = next(each for each in run.header.sensor_objects if each.title == sensor)
    names = [each.key for each in measuring.quantities]
    found = {key: errors(run, measuring, key) for key in names if key not in ("seen", "rate")}
    assert found
    for key, error in found.items():
        assert error is not None, key
        assert np.nanmax(np.abs(error)) < ROUND_OFF, key


@pytest.mark.parametrize("kind", ["range", "scan"])
def test_rays_without_obstacles_have_their_reach(kind: str) -> None:
    """The report of a world without obstacles, whose log has an empty list of them."""
    sensors = {"sensors": [{"type": kind, "reach": 7.0}], "world.obstacles": []}
    empty = cdpr.simulate(CAROCA, overrides={**SHORT, **sensors})
    (sensor,) = empty.header.sensor_objects
    assert (measured_truth(empty, sensor, "distance") == 7.0).all()
    assert f"{kind}_distance_error" in [panel.name for panel in plots.sensors(empty)]


def test_panels(run: Run) -> None:
    panels = {panel.name: panel for panel in plots.sensors(run)}
    assert {"pose_position", "pose_position_error", "scan_distance_error"} <= set(panels)
    assert not any(name.endswith("_age") for name in panels)
    assert panels["receiver_position"].curves[0].points.values == pytest.approx(run["receiver_position"])


def test_axes_and_units_of_an_imu(run: Run) -> None:
    panels = {panel.name: panel for panel in plots.sensors(run)}
    assert [panels[name].label for name in ("imu_force", "imu_turn_rate")] == [
        "imu_force (m/s²)",
        "imu_turn_rate (rad/s)",
    ]
    assert [name for name, _ in panels["imu_force"].legend] == ["x", "y", "z", "measured", "true"]
    assert run.header.layout.fields["imu_force"].labels(()) == ["imu_force_x", "imu_force_y", "imu_force_z"]


def test_ages_are_shown_if_measurements_are_lost() -> None:
    sensors = [{"type": "receiver", "period": 0.004, "dropout": 0.5}, {"type": "imu", "period": 0.004, "delay": 0.002}]
    lossy = cdpr.simulate(CAROCA, overrides={**SHORT, "sensors": sensors})
    ages = [panel.name for panel in plots.sensors(lossy) if panel.name.endswith("_age")]
    assert ages == ["receiver_age"]


def test_noise_has_a_band() -> None:
    sensors = [{"type": "pose", "position": {"noise": 0.01}}, {"type": "twist"}]
    noisy = cdpr.simulate(CAROCA, overrides={**SHORT, "sensors": sensors})
    panel = next(panel for panel in plots.sensors(noisy) if panel.name == "pose_position_error")
    assert panel.limits[0].values == pytest.approx((-0.03, 0.03))
    assert np.std(panel.curves[0].points.values) == pytest.approx(0.01, rel=0.3)


def test_estimate_has_the_band_of_its_sigma(run: Run) -> None:
    added = [column for group in plots.ESTIMATES for column in GROUPS[group].columns]
    sigma = np.linspace(0.1, 1.2, 12)
    values = {
        "estimated_position": run.position + np.array([0.01, 0.0, 0.0]),
        "estimated_orientation": run.orientation,
        "estimated_velocity": run.velocity,
        "estimated_angular_velocity": run.angular_velocity,
        "estimate_sigma": np.tile(sigma, (len(run.rows), 1)),
    }
    blocks = [values.get(c.name, np.full((len(run.rows), c.width or run.header.layout.m), 3.0)) for c in added]
    header = replace(run.header, columns=(*run.header.columns, *added))
    estimated = Run(header, np.concatenate([run.rows, *blocks], axis=1), "finished")
    panels = {panel.name: panel for panel in plots.estimate(estimated)}
    error, upper, lower = panels["estimate_error_position"].curves
    assert np.allclose(error.points.values, [-0.01, 0.0, 0.0], atol=ROUND_OFF)
    assert np.allclose(upper.points.values, 3.0 * sigma[:3])
    assert np.allclose(lower.points.values, -3.0 * sigma[:3])
    assert {*upper.names, *lower.names} == {"±3 σ"}
    assert {"nis", "nees"} <= set(panels)


@pytest.mark.parametrize("name", ["point_mass", "planar"])
def test_robots_without_rotations_have_no_empty_plots(name: str) -> None:
    run = cdpr.simulate(ROOT / "scenarios" / f"{name}.yaml", overrides={"simulation.duration": 0.1})
    shown = {panel.name for drawing in drawings(run) for panel in drawing.shown(run)}
    assert {"position", "velocity", "acceleration", "position_error", "tension"} <= shown
    turning = {"attitude", "angular_velocity", "angular_acceleration", "orientation_error"}
    assert turning & shown == (turning if name == "planar" else set())


def test_corners_of_a_frustum_are_those_of_the_image() -> None:
    camera = cdpr.sensing.Camera(**CAMERA, focal=[700.0, 800.0], size=[640, 480], center=[300.0, 250.0])
    ends = camera.frustum(0.5)
    x, y, z = ((ends[1::4] - camera.position) * [1.0, -1.0, -1.0]).T  # half a turn about x
    assert np.allclose(z, 0.5)
    assert np.allclose(700.0 * x / z + 300.0, [0.0, 640.0, 640.0, 0.0])
    assert np.allclose(800.0 * y / z + 250.0, [0.0, 0.0, 480.0, 480.0])


@pytest.mark.parametrize("kind", HASHES)
def test_types_are_those_of_ros(kind: str) -> None:
    assert type_hash(kind) == HASHES[kind]


def test_messages(tmp_path) -> None:
    folder = tmp_path / "run"
    run = cdpr.simulate(CAROCA, overrides=SHORT, out=folder)
    found: dict[str, list] = {}
    with (folder / "log.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if "/sensors/" in channel.topic:
                content = decode(schema.name.replace("/msg/", "/"), message.data)
                found.setdefault(channel.topic.split("/")[3], []).append((message.log_time, content))
    assert set(found) == {each["type"] for each in ALL}
    time, scan = found["scan"][10]
    k = round(time * 1e-9 / run.header.control_step)
    wanted = run["scan_distance"][k]
    wanted = np.where(wanted >= 3.0, np.inf, wanted)
    assert scan["ranges"] == pytest.approx(wanted, abs=SINGLE)
    assert scan["intensities"] == []
    stamp = scan["header"]["stamp"]["sec"] + 1e-9 * scan["header"]["stamp"]["nanosec"]
    assert stamp == pytest.approx(run.time[k] - run["scan_age"][k], abs=ROUND_OFF)
    assert found["range"][10][1]["range"] == pytest.approx(run["range_distance"][k], abs=SINGLE)
    assert found["range"][10][1]["max_range"] == 10.0
    force = found["imu"][10][1]["linear_acceleration"]
    assert [force[axis] for axis in "xyz"] == run["imu_force"][k].tolist()
    turned = found["pose"][10][1]["pose"]["pose"]["orientation"]
    assert [turned[axis] for axis in "wxyz"] == run["pose_attitude"][k].tolist()
