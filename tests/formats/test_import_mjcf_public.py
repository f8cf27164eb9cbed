"""Small look-alikes of the eight public MJCF cable robots: what is imported, with which warnings, or what to remove."""

from __future__ import annotations

import pytest

import cdpr
from cdpr.base.errors import FormatError
from cdpr.formats import import_file
from cdpr.formats.read.import_files import write

pytest.importorskip("mujoco")

FREE = '<freejoint/><geom type="box" size="0.1 0.1 0.05" mass="5"/>'

ARM = '<body name="arm"><joint name="elbow"/><geom size="0.05" mass="1"/></body>'
FINGERS = (
    '<body name="left"><joint name="l" type="slide" axis="1 0 0"/><geom size="0.02" mass="0.1"/></body>'
    '<body name="right"><joint name="r" type="slide" axis="1 0 0"/><geom size="0.02" mass="0.1"/></body>'
)
ROTORS = '<body name="rotor" pos="3 0 0"><joint name="drum" axis="0 1 0"/><geom size="0.1"/></body>'
WINCHES = "".join(
    f'<body name="winch{k}" pos="{k - 2} 3 0"><joint type="slide" axis="0 0 1"/><geom size="0.1"/><site name="w{k}"/>'
    "</body>"
    for k in range(4)
)
PULLEY = (
    '<body name="pulley" pos="0 0 3"><joint name="turn" axis="0 1 0"/><geom size="0.1"/>'
    '<site name="rim" pos="0.1 0 0"/></body>'
)
SEPARATE = '<body name="hand" pos="0 0 0.8"><freejoint/><geom size="0.05"/></body>'
NO_LIMIT = 'forcerange="-80 0"', ""


def model(servo="position", inside="", world="", equality="", first="", more="", through="", joints=FREE):
    """A box on four cables, and what else a file has."""
    ends = "".join(f'<site name="b{k}" pos="{0.1 * (-1) ** k} {0.1 * (-1) ** (k // 2)} 0"/>' for k in range(4))
    frame = "".join(f'<site name="f{k}" pos="{2 * (-1) ** k} {2 * (-1) ** (k // 2)} 3"/>' for k in range(4))
    cables = "".join(
        f'<spatial name="cable_{k}">{through.format(k=k)}<site site="f{k}"/><site site="b{k}"/></spatial>'
        for k in range(4)
    )
    pulls = "".join(f'<{servo} tendon="cable_{k}" forcerange="-80 0"/>' for k in range(4))
    return (
        f'<mujoco model="crane">{first}\n<worldbody>{frame}{world}\n<body name="box" pos="0 0 1">{joints}{ends}{inside}'
        f"</body></worldbody>\n<equality>{equality}</equality>\n<tendon>{cables}</tendon>"
        f"<actuator>{pulls}{more}</actuator></mujoco>"
    )


IMPORTED = {
    "position servos (HW-RMS, 4 cables)": (model(), ["4 tendons have servos ("]),
    "connect within the gripper (afqmrl, 8CDPRv5)": (
        model(inside=FINGERS, equality='<connect name="c" body1="left" body2="right" anchor="0 0 0"/>'),
        ["body 'left' moves on its own (l): fixed at", "<connect> 'c': between parts of the platform"],
    ),
    "joint equality of the gripper, weld of rotors (damurka5, cdpr)": (
        model(
            inside=FINGERS,
            world=ROTORS,
            equality='<joint name="j" joint1="l" joint2="r"/><weld name="w" body1="rotor"/>',
            more='<position joint="l" kp="5"/>',
        ),
        [
            "<joint> 'j': between parts of the platform",
            "<weld> 'w': between bodies without cables",
            "body 'rotor' moves on its own (drum): no cable ends on it",
            "<position> '': it drives no tendon",
        ],
    ),
    "include, velocity servos and an arm (jssandovala, cdprv3)": (
        model("velocity", inside=ARM, first='<include file="part.xml"/>', more='<motor joint="elbow"/>'),
        ["4 tendons have servos", "body 'arm' moves on its own (elbow): fixed", "body 'chair' moves on its own"],
    ),
    "a scene that includes the robot (damurka5, cdpr_scene)": (
        '<mujoco model="scene"><include file="robot.xml"/><worldbody><light/></worldbody></mujoco>',
        ["robot.xml:5: 4 tendons have servos", "<light>"],
    ),
}
REFUSED = {
    "gripper as a body of its own, on a connect": (
        model(world=SEPARATE, equality='<connect name="c" body1="box" body2="hand" anchor="0 0 0"/>'),
        r"model\.xml:4: <connect> 'c' \(body1 'box', body2 'hand'\).*remove it, or join the bodies",
    ),
    "winches on slides, tendons of three sites (Yang51st, cdpr_8_6)": (
        model(world=WINCHES, through='<site site="w{k}"/>'),
        r"model\.xml:3: body 'box' is a second moving body, besides 'winch0', on which cables end .*remove the joints "
        "of the bodies at rest, and end cables at their last pulley or winch",
    ),
    "the same without the slides": (
        model(world=WINCHES.replace('<joint type="slide" axis="0 0 1"/>', ""), through='<site site="w{k}"/>'),
        r"model\.xml:5: tendon 'cable_0': it has 3 sites, and 'b0' is a third: one on the frame and one on the body",
    ),
    "connects of tendons and pulleys (DanialNejad, Kamal_final)": (
        model(world=PULLEY, through='<site site="rim"/>'),
        r"body 'box' is a second moving body, besides 'pulley', on which cables end \(site 'b0'.*remove the joints",
    ),
    "platform connected to a pulley (DanialNejad, Kamal_final_ver2)": (
        model(world=PULLEY, equality='<connect name="rope" body1="box" body2="pulley" anchor="0 0 0"/>'),
        r"<connect> 'rope' \(body1 'box', body2 'pulley'\).*remove it",
    ),
    "servos without limits": (model().replace(*NO_LIMIT), r"no limited tension: add forcerange=.*--tension MIN,MAX"),
}


@pytest.fixture
def folder(tmp_path):
    chair = '<body name="chair"><freejoint/><geom size="0.1"/></body>'
    (tmp_path / "part.xml").write_text(f"<mujocoinclude><worldbody>{chair}</worldbody></mujocoinclude>")
    (tmp_path / "robot.xml").write_text(model().replace("mujoco", "mujocoinclude").replace(' model="crane"', ""))
    return tmp_path


@pytest.mark.parametrize(("text", "said"), IMPORTED.values(), ids=IMPORTED)
def test_robots_like_public_ones_are_imported(folder, text, said):
    (folder / "model.xml").write_text(text)
    found = import_file(folder / "model.xml")
    told = [*found.warnings, *found.left_out]
    for each in said:
        assert [one for one in told if each in one], (each, told)
    robot = cdpr.load_robot(write(found, folder / "out", force=True)[0])
    assert len(robot.cables) == 4
    assert robot.tension_max.tolist() == [80.0] * 4
    assert robot.tension_min.tolist() == [0.0] * 4


@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED)
def test_others_are_refused_with_what_to_remove(folder, text, said):
    (folder / "model.xml").write_text(text)
    with pytest.raises(FormatError, match=said):
        import_file(folder / "model.xml")
