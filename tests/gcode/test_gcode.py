"""Motions of G-code files: what their words mean in two dialects, where they lead, and what is refused."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from click.testing import CliRunner
from gcode_cases import HEAD, PRINTER, course, points, read, refused, same
from scenario_cases import PLUGINS

from cdpr.base.errors import ScenarioError
from cdpr.scenario import examples, load_scenario
from cdpr.ui.cli import cli

# Words


def test_word_order_and_spacing_have_no_effect(tmp_path):
    plain = "F6000\nG1 X100 Y-20.5 Z1000\nG1 X.5\n"
    other = "; a comment\n%\nn10 f6000 (and one)\nN20g1x100.y-20.5z+1000;\r\n\n x0.5\n%\nnothing"
    same(points(tmp_path, plain), [100, -20.5, 1000], [0.5, -20.5, 1000])
    same(points(tmp_path, other), [100, -20.5, 1000], [0.5, -20.5, 1000])
    same(points(tmp_path, "\ufeffF6000 G 1 X 1 0 0 Z1\n"), [100, 100, 1])


def test_units_offsets_and_relative_coordinates(tmp_path):
    same(points(tmp_path, HEAD + "G20\nG1 X1 Y2\nG21 G1 X1"), [0, 0, 1000], [25.4, 50.8, 1000], [1, 50.8, 1000])
    same(points(tmp_path, "F100 G1 X1", ", units: m"), [1000, 100, 1200])
    same(points(tmp_path, "F100 G1 X1", ", units: inch"), [25.4, 100, 1200])
    relative = "G91\nG1 X10\nX10 Y5\nG90 X0"
    same(points(tmp_path, HEAD + relative), [0, 0, 1000], [10, 0, 1000], [20, 5, 1000], [0, 5, 1000])
    shifted = "G92 X100 Z0\nG1 X110\nG53 G1 X7\nG92.2\nX8\nG92.3\nX100\nG92.1 G1 X1"
    wanted = [[0, 0, 1000], [10, 0, 1000], [7, 0, 1000], [8, 0, 1000], [0, 0, 1000], [1, 0, 1000]]
    same(points(tmp_path, HEAD + shifted), *wanted)
    same(points(tmp_path, "G91 F100 G1 Z-200"), [0, 100, 1000])


def test_g92_1_forgets_what_g92_2_keeps(tmp_path):
    shifted = HEAD + "G92 X100\n{}\nG92.3\nG1 X110\n"
    same(points(tmp_path, shifted.format("G92.2")), [0, 0, 1000], [10, 0, 1000])
    same(points(tmp_path, shifted.format("G92.1")), [0, 0, 1000], [110, 0, 1000])


def test_an_offset_takes_the_place_of_the_one_before(tmp_path):
    same(points(tmp_path, HEAD + "G92 X100\nG1 X110\nG92 X0\nG1 X5"), [0, 0, 1000], [10, 0, 1000], [15, 0, 1000])


def test_g53_counts_from_the_machine_as_the_dialect_has_it(tmp_path):
    relative = "G91\nG1 X10\nG53 X3\nX1"  # LinuxCNC takes G53 as absolute, RepRapFirmware's axes stay relative
    same(points(tmp_path, HEAD + relative), [0, 0, 1000], [10, 0, 1000], [3, 0, 1000], [4, 0, 1000])
    same(points(tmp_path, HEAD + relative, PRINTER), [0, 0, 1000], [10, 0, 1000], [13, 0, 1000], [14, 0, 1000])
    shifted = HEAD + "G92 X100\nG53 G1 X110"  # in RepRapFirmware the machine itself is then at 100
    same(points(tmp_path, shifted), [0, 0, 1000], [110, 0, 1000])
    same(points(tmp_path, shifted, PRINTER), [0, 0, 1000], [10, 0, 1000])


def test_feeds_are_per_minute_and_g0_follows_the_dialect(tmp_path):
    text = "F6000\nG0 X100\nG1 X0\nG20 F60 X1\n"
    np.testing.assert_allclose(course(tmp_path, text).speed, [np.inf, 0.1, 0.0254])
    np.testing.assert_allclose(course(tmp_path, text, PRINTER).speed, [0.1, 0.1, 0.0254])
    np.testing.assert_allclose(course(tmp_path, "G1 X1\nM220 S50\nX2\n", PRINTER).speed, [0.05, 0.025])
    planned = read(tmp_path, HEAD + "G1 X500\n").planned
    found = max(np.linalg.norm(planned.sample(t)[7:10]) for t in np.linspace(0.9, planned.end, 500))
    assert found == pytest.approx(0.1, rel=1e-9)


def test_pauses_have_the_units_of_the_dialect(tmp_path):
    printer = [("G4 P250", 0.25), ("G4 S2", 2.0), ("G4 P250 S2", 2.0)]
    for text, keys, seconds in [("G4 P2", "", 2.0), *((text, PRINTER, seconds) for text, seconds in printer)]:
        with_it = read(tmp_path, f"F6000\nG1 X100\n{text}\nG1 X200\n", keys).planned.end
        none = "M400" if keys else "G4 P0"  # stops, and continues
        without = read(tmp_path, f"F6000\nG1 X100\n{none}\nG1 X200\n", keys).planned.end
        assert with_it - without == pytest.approx(seconds)
        twice = read(tmp_path, f"F6000\nG1 X100\n{text}\n{text}\nG1 X200\n", keys).planned.end
        assert twice - without == pytest.approx(2 * seconds)
        at_first = read(tmp_path, f"{text}\nF6000\nG1 X100\n", keys).planned
        assert at_first.start == pytest.approx(seconds)
    straight = read(tmp_path, "F6000\nG1 X200\n", PRINTER).planned.end
    for nothing in ("G4", "G4 P0", "G4 S-1", "G4 P5 S0"):  # as slicers write it
        told = read(tmp_path, f"F6000\nG1 X100\n{nothing} ; wait\nG1 X200\n", PRINTER)
        assert told.planned.end == pytest.approx(straight)
        assert any("as if without motion: G4" in str(one) for one in told.warnings)


def test_origin_of_the_coordinates(tmp_path):
    same(points(tmp_path, "F100 G1 X0 Y0 Z0\nX100", ", origin: [1, 2, 3]"), [1000, 2000, 3000], [1100, 2000, 3000])
    keys = ", origin: [0, 0.1, 1.2], axes: {rpy_deg: [90, 0, 0]}, scale: 2"
    same(points(tmp_path, "F100 G1 X10 Y20 Z30", keys), [20, 40, 1240])
    apart = keys.replace("[0, 0.1, 1.2]", "[0, 0, 1]")
    same(points(tmp_path, "F100 G1 X10", apart), [20, 100, 1200])  # what is left out stays where it was
    same(points(tmp_path, "G91 F100 G1 Y10", keys), [0, 100, 1220])
    rounded = course(tmp_path, "G64 P0.5\nF100 G1 X10\nY20", keys)
    np.testing.assert_allclose(rounded.tolerance, 2 * 0.5e-3)
    helix = course(tmp_path, "F100 G3 X0 Y200 Z30 J100", keys)
    end = helix.pieces.at(np.array([0]), helix.pieces.length)[0]
    same(1e3 * end, [0, 40, 1600])
    arc = course(tmp_path, "F100 G3 X0 Y200 J100", keys)
    middle = arc.pieces.at(np.array([0]), 0.5 * arc.pieces.length)[0][0]
    same(1e3 * middle[None], [200, 100, 1400])
    assert arc.speed[0] == pytest.approx(0.1 / 60)


# Arcs: radius, sense and angle match their words, by points computed independently


def swept(tmp_path, words, plane="G17"):
    """Return the angle that an arc turns, seen against its axis, and its radii, from points on the way."""
    pieces = course(tmp_path, f"{HEAD}{plane}\n{words}\n").pieces
    k = len(pieces) - 1
    way = pieces.at(np.full(401, k), np.linspace(0, 1, 401) * pieces.length[k])[0]
    x, y = {"G17": (0, 1), "G18": (2, 0), "G19": (1, 2)}[plane]
    bend = way[:, [x, y]]
    # The centre of the circle through three points.
    a, b, c = bend[0], bend[57], bend[131]
    center = np.linalg.solve(2 * np.array([b - a, c - a]), [b @ b - a @ a, c @ c - a @ a])
    arm = bend - center
    return np.degrees(np.ptp(np.unwrap(np.arctan2(arm[:, 1], arm[:, 0])))) * np.sign(
        arm[0, 0] * arm[5, 1] - arm[0, 1] * arm[5, 0]
    ), np.linalg.norm(arm, axis=1)


@pytest.mark.parametrize(
    ("words", "plane", "angle", "radius"),
    [
        ("G3 X100 Y100 J100", "G17", 90, 100),
        ("G2 X100 Y100 I100", "G17", -90, 100),
        ("G2 X100 Y100 J100", "G17", -270, 100),
        ("G3 I-50", "G17", 360, 50),
        ("G2 X0 Y0 I-50", "G17", -360, 50),
        ("G2 I-50 P3", "G17", -1080, 50),
        ("G3 X200 R100", "G17", 180, 100),
        ("G3 X100 Y100 R100", "G17", 90, 100),
        ("G3 X100 Y100 R-100", "G17", 270, 100),
        ("G2 X100 Y100 R100", "G17", -90, 100),
        ("G2 X100 Y100 R-100", "G17", -270, 100),
        ("G90.1\nG3 X100 Y100 I0 J100", "G17", 90, 100),
        ("G92 X50 Y0\nG90.1\nG3 X150 Y100 I50 J100", "G17", 90, 100),
        ("G3 X100 Z1100 I100", "G18", 90, 100),
        ("G2 X100 Z1100 I100", "G18", -270, 100),
        ("G3 Y100 Z1100 K100", "G19", 90, 100),
        ("G3 X0 Y0 Z1100 I-50 P2", "G17", 720, 50),
    ],
)
def test_arcs(tmp_path, words, plane, angle, radius):
    found, radii = swept(tmp_path, words, plane)
    assert found == pytest.approx(angle)
    np.testing.assert_allclose(1e3 * radii, radius, atol=1e-9)


def test_an_arc_whose_centre_is_rounded_ends_at_its_stated_end(tmp_path):
    text = HEAD + "G3 X70.711 Y70.711 I-0.001 J100.02 F600\nG1 X0"
    assert "no arc: its centre is 0.10002 m" in refused(tmp_path, text)[0]
    same(points(tmp_path, HEAD + "G3 X70.711 Y29.289 J100.02")[1:], [70.711, 29.289, 1000])


# Corners


def test_control_mode_of_corners(tmp_path):
    text = HEAD + "G1 X100\nG64 P0.5\nG1 Y100\nG61\nG1 X0\nG64\nG1 Y0\n"
    np.testing.assert_allclose(course(tmp_path, text).tolerance, [0, 0, 5e-4, 0, 0])
    np.testing.assert_allclose(course(tmp_path, text, ", tolerance: 0.01").tolerance, [0.01, 0.01, 5e-4, 0, 0.01])
    gentle = HEAD + "G1 X100 F60000\nX200 Y10\nX300 Y0\nX400 Y10\n"
    ends = [read(tmp_path, gentle, f", tolerance: {tolerance}").planned.end for tolerance in (0, 5e-3)]
    assert ends[1] < ends[0]


def test_short_lines_of_a_curve_are_passed_as_the_curve_is(tmp_path):
    """A circle in chords of 1 mm, to the micron, at a feed for each line, and the same as an arc."""
    angle = np.linspace(0, 2 * np.pi, 629)
    chords = "".join(f"G1 X{100 * np.cos(a):.3f} Y{100 * np.sin(a):.3f} F24000\n" for a in angle[1:])
    begin = "F24000\nG1 X100 Y0 Z1000\nG4 P0\n"
    arc = read(tmp_path, begin + "G3 I-100\n").planned.end
    assert read(tmp_path, begin + chords, ", tolerance: 0.0001").planned.end < 1.1 * arc
    assert read(tmp_path, begin + "G64 P0.1\n" + chords).planned.end < 1.1 * arc
    assert read(tmp_path, begin + chords).planned.end > 10 * arc


# No motion


def test_ineffective_loads_are_reported_once(tmp_path):
    text = 'M104 S200\nT0\nM117 Printing; G1\nG92 E0\nG10\nG1 X10 E5\nG11\nM106 S255\necho "G1 X5"\nG1 X20 E9\nM84\n'
    scenario = read(tmp_path, text, PRINTER)
    (told,) = [str(warning) for warning in scenario.warnings if "trajectory.file" in str(warning)]
    assert told.endswith("trajectory.file: skipped, as if without motion: E, G10, M84, M104, M106, M117, M118, T")
    same(points(tmp_path, text, PRINTER), [10, 100, 1200], [20, 100, 1200])
    milled = "G17 G20 G40 G49 G54 G64 G80 G90 G94\nG21\nT1 M6\nM3 S1000\nM8\n" + HEAD + "M66 P0 L2\nM5 M9\nG1 X5\n"
    (told,) = [str(one) for one in read(tmp_path, milled).warnings if "trajectory.file" in str(one)]
    assert told.endswith(": L, M3, M5, M6, M8, M9, M66, S, T")


def test_the_end_ends(tmp_path):
    same(points(tmp_path, HEAD + "M30\nG1 X5\nnonsense"), [0, 0, 1000])
    same(points(tmp_path, "G1 X5\nM0\nG28\n", PRINTER), [5, 100, 1200])


def test_ignored_words(tmp_path):
    same(points(tmp_path, HEAD + "G92 A0\nG1 X5 A3\n", ", ignore: [A]"), [0, 0, 1000], [5, 0, 1000])
    post = "G43 Z1010 H1\nG41 D2 G1 X5\nG55 X6\nG28 Z0\n"
    same(
        points(tmp_path, HEAD + post, ", ignore: [G28, G41, G43, G55]"),
        [0, 0, 1000],
        [0, 0, 1010],
        [5, 0, 1010],
        [6, 0, 1010],
    )
    same(points(tmp_path, "G28 X Y\nG1 X5 A3\nM98 P5\n", PRINTER + ", ignore: [G28, A, M98]"), [5, 100, 1200])


def test_inverse_times(tmp_path):
    """G93: F is how often the move fits into a minute; G0 is as fast as ever, and neither mode knows the other's F."""
    moves = "G93\nG1 X30 F60\nG2 X50 I10 F30\nG0 X0\nG91 G1 Y7 F1.5\nG90 G94 F600 G1 Y0\n"
    made = course(tmp_path, HEAD + moves)
    np.testing.assert_allclose(made.speed[1:], [0.03, 0.005 * np.pi, np.inf, 0.007 / 40.0, 0.01], rtol=1e-12)
    scaled = course(tmp_path, HEAD + moves, ", scale: 2.0")  # the same times
    np.testing.assert_allclose(scaled.speed[1:], [0.06, 0.01 * np.pi, np.inf, 0.014 / 40.0, 0.01], rtol=1e-12)
    (told,) = [str(one) for one in read(tmp_path, HEAD + "G93 G1 X3000 F60\n").warnings if "velocity" in str(one)]
    assert "are reduced to it; the fastest is 3 m/s in line 3 of a.ngc" in told
    needed = "under G93 each line with G1, G2 or G3 has an F, how often it fits into a minute: 6e-05 or more"
    for text in (
        "G93 F60 G1 X30\nX40",
        "G93 G1 X30 F0",
        "G93 G1 X30 F-1",
        "F600 G93 G0 X30\nG1 X40",
        "G93 G1 X30 F.00001",
    ):
        line, said = refused(tmp_path, f"G0 X1\n{text}\n")[-1].split(": ", 1)
        assert needed in said, (line, said)
    assert "no feed yet" in refused(tmp_path, "F600 G1 X9\nG93 G1 X30 F60\nG94 G1 X40")[-1]
    assert "G93 and G94 exclude each other" in refused(tmp_path, "G93 G94 G1 X40 F60")[-1]
    assert "G93 is not supported" in refused(tmp_path, "G93 G1 X40 F60", PRINTER)[-1]


def test_inverse_times_are_kept_where_limits_let_them(tmp_path):
    """A move that is long against its changes of speed takes about its nominal time, and never less."""
    motion = read(tmp_path, HEAD + "G93 G1 X300 F6\nG0 X0\nG1 X300 F3\n", ", tolerance: 0").trajectory
    quick = read(tmp_path, HEAD + "G0 X300\n", ", tolerance: 0").trajectory
    assert 30.0 < motion.ends() - quick.ends() < 31.0


def test_a_feed_beyond_the_limits_is_reported(tmp_path):
    told = [str(one) for one in read(tmp_path, "F6000\nG1 X5\nF90000 X9\n").warnings]
    text = "trajectory.limits.velocity: feeds above this limit, 1 m/s, are reduced to it; the fastest is 1.5 m/s in "
    assert any(text + "line 3 of a.ngc" in one for one in told)


# Text and checksums


def test_text_is_not_executed(tmp_path):
    text = 'M117 G1 X9\nM291 P"then G1 X9" S1\nM104 S200 T0\nG1X5Y6E.5\n'
    same(points(tmp_path, text, PRINTER), [5, 6, 1200])


def test_a_right_checksum(tmp_path):
    total = 0
    for byte in b"N1 G1 X5":
        total ^= byte
    for comment in ("", " ; a * b", " (a * b) (c*d)"):
        same(points(tmp_path, f"N1 G1 X5*{total}{comment}", PRINTER), [5, 100, 1200])


# The scenario around it


def test_the_resolved_text_is_equal(tmp_path):
    scenario = read(tmp_path, HEAD + "G1 X100\n")
    again = load_scenario(tmp_path / "a.yaml", text=scenario.resolved_yaml(), plugins=PLUGINS)
    assert again == scenario
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert again.planned.end == scenario.planned.end
    elsewhere = tmp_path / "out"
    elsewhere.mkdir()
    moved = scenario.yaml_in(str(elsewhere))
    assert load_scenario(elsewhere / "a.yaml", text=moved, plugins=PLUGINS).planned.end == scenario.planned.end
    (tmp_path / "a.ngc").write_text(HEAD + "G1 X200\n")
    with pytest.raises(ScenarioError, match="has changed: its checksum"):
        load_scenario(tmp_path / "a.yaml", text=scenario.resolved_yaml(), plugins=PLUGINS)


def test_the_example_matches_its_description(tmp_path):
    copies = examples.copy("gcode", tmp_path)
    assert {path.name for path in copies} == {"gcode.yaml", "caroca.yaml", "outline.ngc"}
    done = CliRunner().invoke(cli, ["info", str(tmp_path / "gcode.yaml")])
    assert done.exit_code == 0, done.output
    assert "feasible             100 % of the samples" in done.output
    scenario = load_scenario(tmp_path / "gcode.yaml")
    assert scenario.warnings == ()
    np.testing.assert_allclose(scenario.planned.sample(scenario.planned.end)[:3], [0, 0, 1.2], atol=1e-12)
