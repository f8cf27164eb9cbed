"""Robots for other programs, each loaded by readers that are not ours."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from conftest import ROOT
from docs_cases import PAGES
from export_cases import NAMES, subject_of
from spread import sampled

import cdpr
from cdpr.formats.write import TARGETS
from cdpr.formats.write.export_model import Options, begin, export
from cdpr.mechanics.kinematics import lengths, wrench_matrix
from cdpr.model import rotations

# m, of places and lengths under replayed tensions: nothing but how often numbers are rounded differs.
REPLAYED = 1e-12


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("to", TARGETS)
def test_the_same_text_for_the_same_robot(name, to):
    text = export(subject_of(name), to)
    assert text == export(subject_of(name), to)
    assert all(not line.rstrip().endswith(" nan") for line in text.splitlines())
    ET.fromstring(text)


@pytest.mark.parametrize("name", NAMES)
def test_mujoco_has_the_masses_and_the_lengths(name):
    mujoco = pytest.importorskip("mujoco")
    subject = subject_of(name)
    model = mujoco.MjModel.from_xml_string(export(subject, "mjcf"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    robot = subject.robot
    assert model.body_mass.sum() == robot.platform.mass
    assert np.allclose(np.sort(model.body_inertia[1]), np.linalg.eigvalsh(robot.platform.inertia), rtol=1e-9)
    at = data.site("platform")
    assert np.allclose(at.xpos, subject.state[:3], atol=1e-12)
    R = rotations.matrix(subject.state[3:7])
    assert np.allclose(at.xmat.reshape(3, 3), R, atol=1e-12)
    assert np.allclose(data.subtree_com[1], subject.state[:3] + R @ robot.platform.center_of_mass, atol=1e-9)
    assert np.allclose(data.ten_length, lengths(robot, subject.state), atol=1e-12)
    assert model.nv == robot.n
    tension = np.linspace(robot.tension_min, robot.tension_max, 3)[1]
    data.ctrl[:] = tension
    mujoco.mj_forward(model, data)
    for cable, value in zip(robot.cables, tension, strict=True):
        assert data.sensor(f"{cable.name}_tension").data[0] == pytest.approx(value)
    data.ctrl[:] = 2.0 * robot.tension_max
    mujoco.mj_forward(model, data)
    assert data.sensor(f"{robot.cables[0].name}_tension").data[0] == robot.tension_max[0]


@sampled(
    2,
    ("name", "duration"),
    # Held open loop the last two lean over by themselves: what was rounded grows a hundredfold a second.
    [("caroca", 4.0), ("planar", 4.0), ("cogiro", 4.0), ("spherical", 2.0), ("off_centre_mass", 2.0)],
)
def test_replayed_tensions_give_the_backends_motion(name, duration):
    """The tensions of a run on the backend that has the same engine, held open loop; and the knock of one."""
    mujoco = pytest.importorskip("mujoco")
    scenario = cdpr.load_scenario(
        ROOT / "scenarios" / f"{name}.yaml", backend="mujoco", overrides={"simulation.duration": duration}
    )
    run = cdpr.simulate(scenario)
    model = mujoco.MjModel.from_xml_string(export(begin(scenario), "mjcf"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    steps = round(scenario.simulation.control_step / scenario.simulation.physics_step)
    apart = 0.0
    for tension, external, position, length in zip(run.tension, run.external, run.position, run.length, strict=True):
        mujoco.mj_fwdPosition(model, data)
        apart = max(apart, float(np.abs(data.site("platform").xpos - position).max()))
        apart = max(apart, float(np.abs(data.ten_length - length).max()))
        data.ctrl[:] = tension
        data.xfrc_applied[1] = external  # the knock is a moment alone, which acts alike wherever it is applied
        mujoco.mj_step(model, data, steps)
    assert np.ptp(run.length, axis=0).max() > 0.05
    assert apart <= REPLAYED


@pytest.mark.parametrize("name", ["caroca", "off_centre", "twelve"])  # it does not know the world as a parent
@pytest.mark.parametrize("version", ["1.9", "1.6"])
def test_bullet_reads_the_platform(tmp_path, name, version):
    bullet = pytest.importorskip("pybullet")
    subject = subject_of(name)
    file = tmp_path / "robot.sdf"
    file.write_text(export(subject, "sdf", Options(version=version)))
    client = bullet.connect(bullet.DIRECT)
    try:
        bodies = bullet.loadSDF(str(file), physicsClientId=client)
        found = {}
        for body in bodies:
            for link in range(-1, bullet.getNumJoints(body, physicsClientId=client)):
                if link == -1:
                    called = bullet.getBodyInfo(body, physicsClientId=client)[0]
                else:
                    called = bullet.getJointInfo(body, link, physicsClientId=client)[12]
                found[called.decode()] = bullet.getDynamicsInfo(body, link, physicsClientId=client)[0]
        place, attitude = bullet.getBasePositionAndOrientation(bodies[-1], physicsClientId=client)
    finally:
        bullet.disconnect(client)
    platform = subject.robot.platform
    assert found["platform"] == pytest.approx(platform.mass)
    R = rotations.matrix(subject.state[3:7])
    assert np.allclose(place, subject.state[:3] + R @ platform.center_of_mass, atol=1e-9)
    assert np.allclose(np.roll(attitude, 1), subject.state[3:7], atol=1e-9)


@pytest.mark.parametrize("name", ["caroca", "off_centre"])
def test_dart_reads_mass_inertia_and_pose(tmp_path, name):
    dart = pytest.importorskip("dartpy")
    subject = subject_of(name)
    platform = subject.robot.platform
    for to, ending in (("sdf", "sdf"), ("urdf", "urdf")):
        file = tmp_path / f"robot.{ending}"
        file.write_text(export(subject, to, Options(version="1.6")))
        if to == "sdf":
            world = dart.utils.SdfParser.readWorld(f"file://{file}")
            skeleton = world.getSkeleton(name)
        else:
            skeleton = dart.utils.DartLoader().parseSkeleton(f"file://{file}")
        body = skeleton.getBodyNode("platform")
        assert body.getMass() == pytest.approx(platform.mass)
        assert np.allclose(body.getLocalCOM(), platform.center_of_mass)
        assert np.allclose(body.getInertia().getMoment(), platform.inertia, atol=1e-9)
        pose = body.getWorldTransform()
        assert np.allclose(np.asarray(pose.translation()).ravel(), subject.state[:3], atol=1e-9)
        assert np.allclose(pose.rotation(), rotations.matrix(subject.state[3:7]), atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_urdf_has_a_link_at_each_anchor(tmp_path, name):
    bullet = pytest.importorskip("pybullet")
    subject = subject_of(name)
    file = tmp_path / "robot.urdf"
    file.write_text(export(subject, "urdf"))
    client = bullet.connect(bullet.DIRECT)
    try:
        keep = bullet.URDF_MERGE_FIXED_LINKS * 0 | bullet.URDF_USE_INERTIA_FROM_FILE
        body = bullet.loadURDF(str(file), useFixedBase=True, flags=keep, physicsClientId=client)
        count = bullet.getNumJoints(body, physicsClientId=client)
        links = [bullet.getJointInfo(body, k, physicsClientId=client)[12].decode() for k in range(count)]
        masses = [bullet.getDynamicsInfo(body, k, physicsClientId=client)[0] for k in range(count)]
        places = [bullet.getLinkState(body, k, physicsClientId=client)[4] for k in range(count)]
    finally:
        bullet.disconnect(client)
    robot = subject.robot
    anchors = [f"{cable.name}_{end}" for cable in robot.cables for end in ("frame", "platform")]
    assert sorted(links) == sorted(["platform", *anchors])
    assert sum(masses) == pytest.approx(robot.platform.mass, abs=1e-6)
    R = rotations.matrix(subject.state[3:7])
    for cable in robot.cables:
        assert np.allclose(places[links.index(f"{cable.name}_frame")], cable.frame, atol=1e-6)
        wanted = subject.state[:3] + R @ cable.platform
        assert np.allclose(places[links.index(f"{cable.name}_platform")], wanted, atol=1e-6)


def test_the_mujoco_page_describes_the_behaviour(monkeypatch, tmp_path, capsys):
    """Its model holds the platform where it is; its replay is the run."""
    pytest.importorskip("mujoco")
    held, replayed = re.findall(r"^```python\n(.*?)^```$", PAGES["docs/mujoco.md"], re.DOTALL | re.MULTILINE)
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    monkeypatch.chdir(tmp_path)
    found: dict[str, object] = {}
    exec(held, found)
    data = found["data"]
    assert data.sensor("left").data[0] == pytest.approx(10 * 9.81 / np.sqrt(2))
    assert np.allclose(data.ten_length, np.sqrt(8), atol=1e-9)
    assert np.allclose(data.body("platform").xpos, (0, 0, 1), atol=1e-9)
    capsys.readouterr()
    exec(replayed, {})
    assert float(capsys.readouterr().out) <= REPLAYED


@pytest.mark.parametrize("name", ["planar", "planar_point_mass", "point_mass", "carriage", "spherical"])
def test_held_platforms_move_alike_in_dart_and_mujoco(tmp_path, name):
    """Tensions on MuJoCo's tendons, and their wrench at the origin of the platform that DART reads of the SDF."""
    dart, mujoco = pytest.importorskip("dartpy"), pytest.importorskip("mujoco")
    subject = subject_of(name)
    robot, step = subject.robot, 1e-6
    model = mujoco.MjModel.from_xml_string(export(subject, "mjcf"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    tension = np.linspace(robot.tension_min, robot.tension_max, 5)[1] * np.linspace(1.0, 2.0, robot.m)
    data.ctrl[:] = tension
    mujoco.mj_forward(model, data)
    file = tmp_path / "held.sdf"
    file.write_text(export(subject, "sdf", Options(version="1.6")))
    world = dart.utils.SdfParser.readWorld(f"file://{file}")
    world.setTimeStep(step)
    skeleton = world.getSkeleton(name)
    assert skeleton.getNumDofs() == robot.n
    wrench = wrench_matrix(robot, subject.state) @ tension
    platform = skeleton.getBodyNode("platform")
    platform.addExtForce(wrench[:3], np.zeros(3), False, True)
    platform.addExtTorque(wrench[3:], False)
    world.step()
    found = np.concatenate([np.ravel(platform.getLinearVelocity()), np.ravel(platform.getAngularVelocity())]) / step
    wanted = data.qacc
    if name == "spherical":
        wanted = data.body("platform").xmat.reshape(3, 3) @ wanted
    assert np.allclose(found[robot.rows], wanted, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("name", ["off_centre", "planar", "spherical", "point_mass"])
def test_a_platform_that_moves_begins_with_its_rates(name):
    mujoco = pytest.importorskip("mujoco")
    subject = subject_of(name)
    rates = np.zeros(6)
    rates[subject.robot.rows] = 0.1 * (1.0 + np.arange(subject.robot.n))
    subject = replace(subject, state=np.concatenate([subject.state[:7], rates]))
    model = mujoco.MjModel.from_xml_string(export(subject, "mjcf"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    found = np.zeros(6)
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "platform")
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, found, 0)
    assert np.allclose(np.concatenate([found[3:], found[:3]]), rates, atol=1e-12)


@pytest.mark.parametrize("name", ["caroca", "off_centre"])
def test_mujoco_reads_the_urdf(name):
    """It takes the fixed anchors into their links, and the floating joint for a free one."""
    mujoco = pytest.importorskip("mujoco")
    platform = subject_of(name).robot.platform
    model = mujoco.MjModel.from_xml_string(export(subject_of(name), "urdf"))
    assert (model.nbody, model.nv) == (2, 6)
    assert model.body_mass[1] == pytest.approx(platform.mass)
    assert np.allclose(model.body_ipos[1], platform.center_of_mass, atol=1e-9)
    assert np.allclose(np.sort(model.body_inertia[1]), np.linalg.eigvalsh(platform.inertia))


@pytest.mark.parametrize("name", ["caroca", "off_centre"])
def test_each_colour_of_urdf_is_defined(name):
    """Also of a robot that has no frame to draw: readers warn of materials that have names alone."""
    subject = subject_of(name)
    for robot in (subject.robot, replace(subject.robot, frame=None)):
        root = ET.fromstring(export(replace(subject, robot=robot), "urdf"))
        defined = {each.get("name") for each in root.iter("material") if each.find("color") is not None}
        assert {each.get("name") for each in root.iter("material")} == defined


def test_mujoco_takes_a_tension_that_is_always_the_same():
    mujoco = pytest.importorskip("mujoco")
    subject = subject_of("planar")
    cables = tuple(replace(cable, tension_min=7.0, tension_max=7.0) for cable in subject.robot.cables)
    text = export(replace(subject, robot=replace(subject.robot, cables=cables)), "mjcf")
    assert np.allclose(mujoco.MjModel.from_xml_string(text).actuator_ctrlrange, 7.0, rtol=1e-15, atol=0.0)
