"""Rendered images: markers against projected ones, files, live messages, determinism, machines without renderers."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.log.image_file import complete_images, stored_images
from cdpr.log.images import cameras_of, images, png
from cdpr.sensing import rendering
from cdpr.ui.gui.images import LatestImages
from cdpr.ui.live.messages import Messages

SCENARIO = ROOT / "scenarios" / "camera.yaml"
TYPES = get_typestore(Stores.ROS2_HUMBLE)
POINTS = np.array([[0.5, 0.25, 0.6], [-0.5, 0.25, 0.5], [-0.5, -0.25, 0.7], [0.5, -0.25, 0.6], [0.1, 0.0, 0.9]])
AXES = Rotation.from_euler("x", np.pi) * Rotation.from_rotvec([0.05, 0.02, 0.4])
PLACE = np.array([0.1, -0.1, 5.0])
CENTROID = 0.5  # px
UNDISTURBED = "sensor 'roof' of the type camera measures nothing that an event can disturb.*allowed: markers"
SHORT = {"simulation.duration": 0.2}


def usable(name):
    """Skip without the renderer."""
    try:
        rendering.make_renderer(name, rendering.Lens((100.0, 100.0), (8.0, 8.0), (16, 16))).close()
    except cdpr.CdprError as error:
        pytest.skip(str(error))


@pytest.fixture(params=["mujoco", "bullet"])
def renderer(request):
    usable(request.param)
    return request.param


def looking(renderer, on="world", **more):
    """A run with one camera and markers, whose rows tests change."""
    attitude = AXES.as_quat(scalar_first=True).tolist()
    lens = {"focal": [800.0, 780.0], "center": [310.0, 250.0], "on": on}
    # A camera on the platform looks down on markers in the hall.
    place, points = (PLACE, POINTS) if on == "world" else (np.array([0.0, 0.1, -0.3]), POINTS - [0.0, 0.0, 2.0])
    mount = {"position": place.tolist(), "attitude": attitude, **lens}
    camera = {"type": "camera", "name": "eye", "renderer": renderer, "marker_radius": 0.03, **mount, **more}
    sensors = [camera, {"type": "markers", "markers": points.tolist(), **mount}]
    overrides = {"simulation.duration": 0.01, "world.obstacles": [], "sensors": sensors}
    return cdpr.simulate(SCENARIO, overrides=overrides), place, points


@pytest.mark.parametrize("on", ["world", "platform"])
@pytest.mark.parametrize(
    "count", [pytest.param(4, id="4 poses"), pytest.param(100, id="100 poses", marks=pytest.mark.slow)]
)
def test_rendered_markers_are_where_projected_ones_are(renderer, on, count):
    run, place, points = looking(renderer, on)
    camera, row, rng = cameras_of(run.header)[0], run.rows[0].copy(), np.random.default_rng(0)
    columns, found = run.header.layout.columns, 0
    for _ in range(count):
        position = np.array([0.0, 0.0, 1.5]) + rng.uniform(-0.4, 0.4, 3)
        body = Rotation.from_rotvec(rng.uniform(-0.3, 0.3, 3))
        row[columns["position"]], row[columns["orientation"]] = position, body.as_quat(scalar_first=True)
        if on == "world":
            seen = AXES.inv().apply(position + body.apply(points) - place)
        else:
            seen = (body * AXES).inv().apply(points - position - body.apply(place))
        pixels = seen[:, :2] / seen[:, 2:] * [800.0, 780.0] + [310.0, 250.0]
        found += len(list(distances(camera.image(row), pixels, 0.03 * 790.0 / seen[:, 2])))
    camera.close()
    assert found >= 2 * count  # others are at the edge of the image, or behind a cable or another marker


def distances(image, pixels, radii):
    """Distance (px) of the centroid of each marker that is wholly visible from its projection."""
    red = image[:, :, 0].astype(int) - image[:, :, 1] > 60
    v, u = np.mgrid[: image.shape[0], : image.shape[1]] + 0.5
    for k, (pixel, radius) in enumerate(zip(pixels, radii, strict=True)):
        reach = radius + 3.0
        others = np.delete(pixels, k, axis=0)
        inside = (pixel > reach).all() and (pixel < [image.shape[1] - reach, image.shape[0] - reach]).all()
        if not inside or np.linalg.norm(others - pixel, axis=1).min() < 2.5 * reach:
            continue
        own = red & (np.hypot(u - pixel[0], v - pixel[1]) < reach)
        if own.sum() < 0.9 * np.pi * radius**2:
            continue  # hidden in part
        near = float(np.hypot(u[own].mean() - pixel[0], v[own].mean() - pixel[1]))
        assert near < CENTROID
        yield near


def test_images_follow_the_state_and_both_renderers_agree():
    for name in rendering.RENDERERS:
        usable(name)
    found = {}
    for name in rendering.RENDERERS:
        changes = {f"sensors.{i}.renderer": name for i in (0, 1)}
        run = cdpr.simulate(SCENARIO, overrides={**changes, "simulation.duration": 0.5})
        pictures = list(images(run, "roof"))
        assert [time for time, _ in pictures] == pytest.approx(np.arange(6) * 0.1)
        assert not np.array_equal(pictures[0][1], pictures[-1][1])
        found[name] = pictures[-1][1]
        assert len({tuple(colour) for colour in found[name].reshape(-1, 3)[::7].tolist()}) > 3
    # The markers alone have one colour in both: the same pixels but for their edges.
    red = [(image[:, :, 0].astype(int) - image[:, :, 1] > 100) for image in found.values()]
    assert red[0].sum() > 50
    assert np.logical_xor(*red).sum() < 0.5 * red[0].sum()


def test_the_example_shows_boxes_below_the_platform_all_the_time(renderer):
    run = cdpr.simulate(SCENARIO, overrides={"sensors.1.renderer": renderer, "sensors.1.period": 0.5})
    shares = [(image != image[0, 0]).any(axis=2).mean() for _, image in images(run, "tool")]
    assert len(shares) == 9
    assert min(shares) > 0.03  # of the pixels


def test_a_camera_changes_no_bit_of_the_rows():
    with_cameras = cdpr.simulate(SCENARIO, overrides=SHORT)
    without = cdpr.simulate(SCENARIO, overrides={**SHORT, "sensors": []})
    assert with_cameras.header.layout.width == without.header.layout.width + 5 * 3 + 1
    for name in without.header.layout.columns:
        assert np.array_equal(with_cameras[name], without[name])


def test_estimators_ignore_cameras():
    camera = {"type": "camera", "position": [0.0, 0.0, 5.0], "attitude": [0, 1, 0, 0]}
    changes = {"sensors": [camera, {"type": "encoders"}], "estimator": {"type": "forward_kinematics"}, **SHORT}
    run = cdpr.simulate(SCENARIO, overrides=changes)
    assert run["estimated_position"] == pytest.approx(run.position, abs=1e-6)


def test_images_go_to_a_file_with_the_same_bits_each_time(tmp_path):
    usable("auto")
    for name in ("one", "two"):
        cdpr.simulate(SCENARIO, overrides=SHORT, out=str(tmp_path / name))
    files = [tmp_path / name / "images.mcap" for name in ("one", "two")]
    assert files[0].read_bytes() == files[1].read_bytes()
    with files[0].open("rb") as file:
        found = [(channel.topic, schema.name, one) for schema, channel, one in make_reader(file).iter_messages()]
    assert [topic for topic, *_ in found].count("/cdpr/sensors/roof/compressed") == 3
    assert [topic for topic, *_ in found].count("/cdpr/sensors/tool/compressed") == 3
    for topic, schema, one in found:
        assert schema == "sensor_msgs/msg/CompressedImage"
        image = TYPES.deserialize_cdr(one.data, schema)
        assert image.header.frame_id == f"{topic.split('/')[3]}_frame"
        assert image.header.stamp.sec * 10**9 + image.header.stamp.nanosec == one.log_time
        assert image.format == "png"
        assert bytes(image.data)[:8] == b"\x89PNG\r\n\x1a\n"
    again = [png(image) for _, image in images(cdpr.load_run(tmp_path / "one"), "roof")]
    assert again == [bytes(TYPES.deserialize_cdr(one.data, s).data) for topic, s, one in found if "roof" in topic]


def test_interactive_events_of_cameras_are_rejected():
    with cdpr.Simulation(SCENARIO, overrides=SHORT) as simulation:
        simulation.step(10)
        with pytest.raises(cdpr.CdprError, match=UNDISTURBED):
            simulation.fail_sensor("roof")
        simulation.fail_sensor("markers")


def test_logs_contain_the_lens_beside_the_images(tmp_path):
    usable("auto")
    cdpr.simulate(SCENARIO, overrides=SHORT, out=str(tmp_path / "run"))
    with (tmp_path / "run" / "log.mcap").open("rb") as file:
        reader = make_reader(file)
        found = [
            (one.log_time, TYPES.deserialize_cdr(one.data, schema.name))
            for schema, _, one in reader.iter_messages(topics="/cdpr/sensors/roof/camera_info")
        ]
    assert [time for time, _ in found] == [0, 100_000_000, 200_000_000]  # as the images
    for time, lens in found:
        assert lens.header.stamp.sec * 10**9 + lens.header.stamp.nanosec == time
        assert (lens.width, lens.height, lens.header.frame_id) == (640, 480, "roof_frame")
        assert lens.k.tolist() == [400.0, 0.0, 320.0, 0.0, 400.0, 240.0, 0.0, 0.0, 1.0]


@pytest.mark.parametrize("left", [b"", b"\x89MCAP0\r\n", None], ids=["empty", "begun", "none"])
@pytest.mark.usual("begun")
def test_repair_renders_the_images_of_a_killed_run(tmp_path, left):
    usable("auto")
    folder = tmp_path / "run"
    cdpr.simulate(SCENARIO, overrides=SHORT, out=str(folder))
    images_file = folder / "images.mcap"
    whole = images_file.read_bytes()
    command = partial(cdpr_here, "repair", str(folder))
    assert "rendered" not in command().stdout
    images_file.unlink()
    if left is not None:
        images_file.write_bytes(left)
    log = folder / "log.mcap"
    log.write_bytes(log.read_bytes()[:-20])  # as of a run that was killed at its end
    assert f"{images_file}: rendered" in command().stdout
    assert images_file.read_bytes() == whole


def flipped(data, place):
    data = bytearray(data)
    data[place] ^= 1
    return bytes(data)


@pytest.mark.slow
def test_foreign_and_damaged_images_are_rendered_again(tmp_path):
    usable("auto")
    small = {**SHORT, "sensors.0.size": [32, 24], "sensors.1.size": [32, 24], "log.step": 0.1}
    run = cdpr.simulate(SCENARIO, overrides=small, out=str(tmp_path / "run"))
    other = {**small, "initial.position": [0.0, 0.0, 1.0]}  # with the same topics and times
    cdpr.simulate(SCENARIO, overrides=other, out=str(tmp_path / "other"))
    file = tmp_path / "run" / "images.mcap"
    whole = file.read_bytes()

    def usable_images():
        with stored_images(run) as reader:
            return reader is not None

    assert usable_images()
    of_other = (tmp_path / "other" / "images.mcap").read_bytes()
    for left in (flipped(whole, len(whole) // 2), flipped(whole, -60), flipped(whole, -3), whole[:-9], of_other):
        file.write_bytes(left)
        assert not usable_images()
    file.unlink()
    os.mkfifo(file)  # which no one writes
    assert not usable_images()
    assert complete_images(run) == file
    assert file.read_bytes() == whole


def test_png_holds_the_pixels():
    pillow = pytest.importorskip("PIL.Image")
    import io

    image = np.random.default_rng(0).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    assert np.array_equal(np.asarray(pillow.open(io.BytesIO(png(image)))), image)


def test_live_messages_contain_an_image_in_each_period():
    usable("auto")
    run = cdpr.simulate(SCENARIO, overrides=SHORT)
    made = Messages(run.header)
    names = [topic.name for topic in made.topics]
    roof = names.index("/cdpr/sensors/roof/compressed")
    wanted = [k == roof for k in range(len(names))]
    sent = [(sample, *one) for sample in (3, 20, 49, 50, 77, 100) for one in made.of(run.rows[sample], sample, wanted)]
    made.close()
    assert [(sample, k) for sample, k, _ in sent] == [(3, roof), (50, roof), (100, roof)]
    first = TYPES.deserialize_cdr(sent[0][2], "sensor_msgs/msg/CompressedImage")
    assert first.header.stamp.nanosec == 6_000_000
    assert not list(made.of(run.rows[0], 0, [False] * len(names)))


@pytest.mark.parametrize("cut", [False, True])
def test_a_cable_cut_live_is_not_drawn_any_more(cut):
    usable("auto")
    with cdpr.Simulation(SCENARIO, overrides=SHORT) as sim:
        start = sim.header
        if cut:
            sim.cut(3)
        sim.step(1)
        row, header = sim.row.copy(), sim.header
    made, latest, sent, shown = Messages(start), LatestImages(start), [], []
    markers, image = (
        [topic.name == name for topic in made.topics] for name in ("/cdpr/markers", "/cdpr/sensors/roof/compressed")
    )
    for each, sample in ((start, 0), (header, 1000)):
        made.amend(each)
        latest.amend(each)
        (_, drawn), (_, rendered) = *made.of(row, 0, markers), *made.of(row, sample, image)
        sent.append((drawn, rendered[12:]))  # after the time
        assert latest.take(sample, row)
        shown.append([camera["png"] for camera in latest.message["cameras"]])
    made.close()
    latest.close()
    assert [one != other for one, other in zip(*sent, strict=True)] == [cut, cut]
    assert (shown[0] != shown[1]) == cut


def hide(monkeypatch, *missing):
    find = importlib.util.find_spec
    monkeypatch.setattr(rendering, "find_spec", lambda name: None if name in missing else find(name))


def test_without_a_renderer_a_run_names_the_remedy(monkeypatch, tmp_path):
    hide(monkeypatch, "mujoco", "pybullet")
    with pytest.raises(cdpr.CdprError, match=r"needs mujoco or pybullet.*pip install 'cdpr\[mujoco\]'"):
        cdpr.simulate(SCENARIO, overrides=SHORT, out=str(tmp_path / "run"))
    assert not (tmp_path / "run" / "run.json").exists()


def test_without_egl_a_run_takes_bullet_or_fails_at_its_start(monkeypatch, tmp_path):
    mujoco = pytest.importorskip("mujoco")
    monkeypatch.delattr(mujoco, "egl", raising=False)
    monkeypatch.setitem(sys.modules, "mujoco.egl", None)  # as without its library: the import fails
    changes = {"sensors.0.renderer": "mujoco", **SHORT}
    with pytest.raises(cdpr.CdprError, match="renderer 'mujoco' does not work on this machine: no EGL device"):
        cdpr.simulate(SCENARIO, overrides=changes, out=str(tmp_path / "run"))
    pytest.importorskip("pybullet")
    cdpr.simulate(SCENARIO, overrides=SHORT, out=str(tmp_path / "other"))
    assert (tmp_path / "other" / "images.mcap").exists()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"sensors.0.delay": 0.1}, r"sensors\[0\].delay: must be 0 for a camera"),
        ({"sensors.0.period": 0.0}, r"sensors\[0\].period: must be greater than 0"),
        ({"sensors.0.period": 0.0011}, r"sensors\[0\].period: "),
        ({"sensors.0.period": 0.01, "log.step": 0.004}, "expected an integer multiple of log.step, 0.004 s, got 0.01"),
        ({"sensors.0.attitude": [1, 1, 0, 0]}, "expected a unit quaternion"),
        ({"sensors.0.size": [0, 10]}, r"sensors\[0\].size\[0\]: must be at least 1"),
        ({"sensors.0.renderer": "paint"}, r"sensors\[0\].renderer: "),
        ({"sensors.1.name": "roof"}, "both named 'roof'"),
        ({"sensors.0.focal": [1e12, 1e12]}, "focal: expected at most 640000 px and 480000 px"),
        ({"sensors.0.focal": [400, 1e-300]}, "focal: expected at least 0.64 px and 0.48 px"),
        ({"sensors.0.center": [1e300, 0]}, r"center: expected at most 640000 px and 480000 px in size"),
        ({"sensors.0.believed": {"focal": [410, 410]}}, r"sensors\[0\].believed: must be omitted for a camera"),
        *[
            ({"events": [{"time": 0.1, "sensor": "roof", **event}]}, rf"events\[0\].sensor: {UNDISTURBED}")
            for event in (
                {"type": "sensor_failure"},
                {"type": "sensor_occlusion", "duration": 0.1},
                {"type": "sensor_bump", "position": [0.1, 0, 0]},
                {"type": "sensor_bump", "bias": 0.1},
            )
        ],
    ],
)
def test_invalid_cameras_are_rejected(change, text):
    with pytest.raises(cdpr.CdprError, match=text):
        cdpr.simulate(SCENARIO, overrides={**SHORT, **change})


def test_unknown_cameras_of_a_run_are_reported():
    run = cdpr.simulate(SCENARIO, overrides=SHORT)
    with pytest.raises(cdpr.CdprError, match="no camera named 'sky': expected roof or tool"):
        next(images(run, "sky"))
    without = cdpr.simulate(SCENARIO, overrides={**SHORT, "sensors": []})
    with pytest.raises(cdpr.CdprError, match="no camera: expected a sensor of the type camera"):
        next(images(without))


def test_runs_without_cameras_import_nothing(tmp_path):
    code = (
        "import sys, cdpr; cdpr.simulate('caroca', overrides={'simulation.duration': 0.01}, out=sys.argv[1]); "
        "sys.exit(any('rendering' in name or name in ('cdpr.log.images', 'mujoco') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code, str(tmp_path / "run")], timeout=60).returncode == 0
    assert not (tmp_path / "run" / "images.mcap").exists()
