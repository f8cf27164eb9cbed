import re
import subprocess
import sys
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import ROOT
from hypothesis import example, given
from hypothesis import strategies as st
from report_cases import CASES, diverged_run, infeasible_run, make_run
from spread import sampled

from cdpr.log.event import Event
from cdpr.log.run import Run
from cdpr.ui.report.figures import run as figures
from cdpr.ui.report.figures import sketch
from cdpr.ui.report.figures.canvas import Chart, inline_svg
from cdpr.ui.report.figures.overlay import number_groups
from cdpr.ui.report.figures.panels import stack
from cdpr.ui.report.figures.svg import OnPage, numbers, ticks_within
from cdpr.ui.report.plots import run as panels
from cdpr.ui.report.plots.histories import histories, roll_pitch_yaw
from cdpr.ui.report.plots.pictures import pictures_of
from cdpr.ui.report.style import AXES, CABLES, LEAST_ERROR, shorten


def _drawn(panels, run):
    return figures.charted(run, panels(run))


def _on_page(panels, run):
    return stack(run, panels(run), OnPage)


def sketched(run):
    return sketch.draw(pictures_of(histories(run).outline))


PANELS = ("pose", "velocity", "acceleration", "errors", "tensions", "cables", "distribution", "energy")
drawings = {name: partial(_drawn, getattr(panels, name)) for name in PANELS}
plots = SimpleNamespace(overview=lambda run: run.plot(), **drawings)
pages = SimpleNamespace(**{name: partial(_on_page, getattr(panels, name)) for name in PANELS})

FIGURES = (
    sketched,
    *vars(pages).values(),
    plots.overview,
    plots.pose,
    plots.velocity,
    plots.acceleration,
    plots.errors,
    plots.tensions,
    plots.cables,
    plots.distribution,
    plots.energy,
)


def markup(figure: Chart | OnPage) -> str:
    return figure.markup("test") if isinstance(figure, OnPage) else inline_svg(figure, "test", "test")


def texts(figure: Chart | OnPage) -> list[str]:
    """Everything written in a figure."""
    root = ElementTree.fromstring(markup(figure))
    return ["".join(node.itertext()).strip() for node in root.iter("{http://www.w3.org/2000/svg}text")]


@sampled(
    4,
    ("draw", "labels"),
    [
        (
            plots.overview,
            ["position (m)", "position error (mm)", "orient. error (mrad)", "cable tension (N)"],
        ),
        (plots.pose, ["position (m)", "attitude (°)", "roll", "pitch", "yaw", "desired", "actual"]),
        (plots.velocity, ["velocity (m/s)", "angular velocity (rad/s)", "x", "y", "z", "desired", "actual"]),
        (plots.acceleration, ["acceleration (m/s²)", "angular accel. (rad/s²)", "desired", "actual"]),
        (plots.errors, ["position error (mm)", "orient. error (mrad)", "norm"]),
        (plots.tensions, ["cable tension (N)", "cable_1", "cable_8", "t_min 20 N", "t_max 650 N"]),
        (plots.cables, ["cable length (m)", "length rate (m/s)", "cable_1", "cable_8"]),
        (plots.distribution, ["margin (N)", "residual (N)", "at a limit (0 N)", "10⁻¹²"]),
        (
            sketched,
            ["x", "y", "z", "axes, 1 m long", "start, 0 s", "end, 4 s", "8: cable_8", "desired path"],
        ),
    ],
)
def test_quantities_units_and_names_are_written(draw, labels: list[str]) -> None:
    written = texts(draw(make_run()))
    assert not set(labels) - set(written)
    if draw is not sketched:
        assert "time (s)" in written


@pytest.mark.parametrize("name", PANELS)
@sampled(1, "case", ["whole", "infeasible", "diverged"])
@pytest.mark.usual("whole-tensions", "whole-errors")
def test_pages_match_figures_of_the_library(name, case) -> None:
    """The same words at the same ticks, whatever draws them; a common power of ten is written in another way."""
    run = {"whole": make_run, "infeasible": infeasible_run, "diverged": diverged_run}[case]()
    plain = [
        [text for text in texts(of[name](run)) if "e" not in text and "×" not in text] for of in (drawings, vars(pages))
    ]
    assert sorted(plain[0]) == sorted(plain[1])


def test_errors_are_drawn_in_millimetres_and_milliradians() -> None:
    run = make_run()
    position, orientation = plots.errors(run).axes
    for axes, values in ((position, 1e3 * run.position_error), (orientation, 1e3 * run.orientation_error)):
        norm, *components = axes.lines
        assert norm.get_ydata().max() == pytest.approx(np.linalg.norm(values, axis=1).max())
        assert [line.get_color() for line in components] == list(AXES)
        for line, column in zip(components, values.T, strict=True):
            assert line.get_ydata().max() == pytest.approx(column.max())
            assert line.get_ydata().min() == pytest.approx(column.min())


def test_desired_is_dashed_and_actual_is_not() -> None:
    run = make_run()
    actual, desired = plots.velocity(run).axes[0].lines[:3], plots.velocity(run).axes[0].lines[3:6]
    assert [line.get_linestyle() for line in actual] == ["-"] * 3
    assert [line.get_linestyle() for line in desired] == ["--"] * 3
    assert desired[0].get_ydata().max() == run.desired_velocity[:, 0].max()


@pytest.mark.slow
def test_a_tension_peak_of_one_sample_is_drawn() -> None:
    run = make_run(rows=20_000)
    table = run.rows.copy()
    table[14_321, run.header.layout.columns["tension"].start + 2] = 640.0
    line = plots.tensions(replace(run, rows=table)).axes[0].lines[2]
    assert line.get_ydata().max() == 640.0
    assert line.get_xdata()[line.get_ydata().argmax()] == pytest.approx(14.321)


def test_limits_are_drawn_in_view() -> None:
    axes = plots.tensions(make_run(limits=(20.0, 650.0))).axes[0]
    dashed = [line.get_ydata()[0] for line in axes.lines[8:]]
    assert dashed == [20.0, 650.0]
    low, high = axes.get_ylim()
    assert low < 20.0
    assert high > 650.0


def test_distant_limits_are_in_the_legend_and_do_not_scale_the_axis() -> None:
    run = make_run(limits=(1.0, 20_000.0))
    figure = plots.tensions(run)
    low, high = figure.axes[0].get_ylim()
    assert np.ptp(run.tension) > 0.5 * (high - low)
    written = texts(figure)
    assert written[written.index("t_max 20000 N") + 1] == "(out of view)"
    assert written.count("(out of view)") == 1


def test_limits_of_single_cables_are_distinguished() -> None:
    run = make_run()
    run = replace(run, header=replace(run.header, tension_max=(650.0,) * 3 + (700.0,) * 5))
    figure = plots.tensions(run)
    assert "t_max 650–700 N" in texts(figure)
    assert [line.get_color() for line in figure.axes[0].lines[-2:]] == [CABLES[0], CABLES[3]]


def test_limits_that_change_are_those_at_first() -> None:
    run = replace(make_run(), events=(Event(1.0, "limits", "other limits"),))
    assert "t_max at first 650 N" in texts(plots.tensions(run))


@pytest.mark.slow
def test_energies_and_where_there_is_one_the_external_wrench() -> None:
    run = make_run()
    labels = [axes.get_ylabel() for axes in plots.energy(run).axes]
    assert labels == ["energy (J)", "power (W)", "unexplained (J)"]
    assert len(plots.energy(run).axes[0].lines) == 3
    table = run.rows.copy()
    table[500:, run.header.layout.columns["external"]] = 5.0
    table[:, run.header.layout.columns["external_work"]] = run.time[:, None]
    figure = plots.energy(replace(run, rows=table))
    assert [axes.get_ylabel() for axes in figure.axes] == ["external force (N)", "external moment (N m)", *labels]
    assert len(figure.axes[2].lines) == 4
    assert figure.axes[3].lines[1].get_ydata()[:-1] == pytest.approx(1.0)  # 1 J each second
    assert "external work" in texts(figure)


def test_twelve_cables_differ_in_colour_or_dashes() -> None:
    lines = plots.cables(make_run(m=12)).axes[0].lines
    assert len({(line.get_color(), str(line._dash_pattern)) for line in lines}) == 12
    assert len({line.get_color() for line in lines}) == 8


def test_a_constant_quantity_is_not_blown_up_to_its_round_off() -> None:
    run = make_run()
    table = run.rows.copy()
    for name in ("position", "desired_position"):
        table[:, run.header.layout.columns[name]] = 1.0 + 1e-15 * np.arange(3)
    low, high = plots.pose(replace(run, rows=table)).axes[0].get_ylim()
    assert high - low >= 1e-3


def test_errors_of_round_off_are_not_blown_up() -> None:
    run = make_run()
    table, columns = run.rows.copy(), run.header.layout.columns
    for name in ("position", "orientation"):
        table[:, columns[name]] = table[:, columns[f"desired_{name}"]]
    table[:, columns["position"]] += 1e-15 * np.arange(3)
    for axes in plots.errors(replace(run, rows=table)).axes[:2]:
        assert np.ptp(axes.get_ylim()) >= LEAST_ERROR


@pytest.mark.slow
def test_failed_steps_are_shaded_in_every_panel_and_named() -> None:
    run = infeasible_run()
    figure = plots.pose(run)
    written = texts(figure)
    assert {"infeasible", "not found"} <= set(written)
    assert "unsupported" not in written
    for axes in figure.axes:
        infeasible, not_found = (patch.get_path().get_extents() for patch in axes.patches)
        assert (infeasible.x0, infeasible.x1) == pytest.approx((0.9, 1.1))
        assert not_found.x0 == pytest.approx(1.3)
        assert not_found.width > 0.002 * 4.0  # one step, wide enough to be seen
    assert not {"infeasible", "event (number)"} & set(texts(plots.pose(make_run())))


@pytest.mark.slow
def test_events_are_numbered_in_the_order_of_time_and_kept_inside() -> None:
    run = replace(make_run(), events=(Event(9.0, "stopped", "late"), Event(1.0, "infeasible", "early", until=2.0)))
    figure = plots.overview(run)
    assert "1 infeasible at 1 s;  2 stopped at 9 s" in texts(figure)
    numbers = [text for text in figure.axes[0].texts if text.get_text() in ("1", "2")]
    assert [text.get_position()[0] for text in numbers] == pytest.approx([1.0, 4.0])


def test_events_close_together_share_a_mark() -> None:
    assert number_groups([0.0, 0.01, 0.02, 1.0], 0.1) == [(0.0, "1–3"), (1.0, "4")]
    assert number_groups([], 0.1) == []


def test_a_diverging_end_does_not_flatten_what_led_to_it() -> None:
    run = diverged_run()
    figure = plots.pose(run)
    low, high = figure.axes[0].get_ylim()
    assert high - low < 10.0
    assert any(text.startswith("out of view: up to ") for text in texts(figure))


@pytest.mark.slow
@pytest.mark.parametrize("last", [np.inf, np.nan, 1e300, 1.7e308])
def test_any_last_value_can_be_drawn(last: float) -> None:
    run = diverged_run(last)
    for k, draw in enumerate(FIGURES):
        text = markup(draw(replace(run, status="failed") if k % 2 else run))
        assert not re.search(r"\b(nan|inf)\b", re.sub(r">[^<]*<|aria-label=\"[^\"]*\"", "", text))


def test_attitude_has_no_jump_of_a_turn() -> None:
    run = make_run()
    columns = run.header.layout.columns
    table = run.rows.copy()
    angle = np.linspace(3.0, 6.0, len(table))  # yaw passes pi; the quaternion's sign is flipped on the way
    yaw = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    table[:, columns["desired_orientation"]] = yaw
    table[:, columns["orientation"]] = -yaw
    desired, actual = roll_pitch_yaw(replace(run, rows=table))
    assert np.allclose(np.diff(desired[:, 2]), 3.0 / (len(table) - 1))
    assert np.allclose(actual, desired)


def test_roll_pitch_yaw_follow_the_convention() -> None:
    from cdpr.model.rotations import from_rpy

    run = make_run(rows=2)
    table = run.rows.copy()
    table[:, run.header.layout.columns["desired_orientation"]] = from_rpy(0.1, -0.2, 0.3)
    desired, _ = roll_pitch_yaw(replace(run, rows=table))
    assert np.allclose(desired[0], [0.1, -0.2, 0.3])


def test_a_planar_robot_is_seen_square_on() -> None:
    run = make_run(m=4)
    anchors = tuple((x, 0.0, z, 0.0, 0.0, 0.0) for x in (-3.0, 3.0) for z in (0.0, 3.0))
    table = run.rows.copy()
    for name in ("position", "desired_position"):
        table[:, run.header.layout.columns[name].start + 1] = 0.0
    written = texts(sketched(replace(run, header=replace(run.header, anchors=anchors), rows=table)))
    assert {"x", "z"} <= set(written)
    assert "y" not in written


@pytest.mark.parametrize("shape", [None, {"sphere": 0.2}, {"box": [0.2, 0.2, 0.2]}])
def test_every_shape_of_a_platform_can_be_drawn(shape) -> None:
    run = make_run(rows=10)
    text = markup(sketched(replace(run, header=replace(run.header, shape=shape))))
    assert text.count('z" style=') == {"None": 0, "sphere": 2, "box": 9}[next(iter(shape)) if shape else "None"]


def test_long_names_keep_their_ends() -> None:
    assert shorten("left") == "left"
    assert shorten("a\nb") == "a b"
    short = shorten("upper_platform_winch_number_7_left")
    assert len(short) == 26
    assert short.startswith("upper_pl")
    assert short.endswith("_7_left")


def test_strange_names_are_text() -> None:
    names = ("<script>", "--><b>", "$\\frac{1", "$a$", "&amp;", "索", "", "%s {x}")
    run = make_run(names=names)
    written = texts(plots.tensions(run))
    assert set(names) - {""} <= set(written)


def test_run_plot_gives_a_figure_that_notebooks_show() -> None:
    figure = make_run(rows=100).plot()
    assert isinstance(figure, Chart)
    assert figure._repr_svg_().startswith("<svg ")


def test_the_readers_style_changes_nothing() -> None:
    import matplotlib as mpl

    plain = inline_svg(plots.pose(make_run(rows=100)), "key", "label")
    with mpl.rc_context({"font.size": 20, "axes.facecolor": "black", "axes.grid": False, "lines.linewidth": 9}):
        assert inline_svg(plots.pose(make_run(rows=100)), "key", "label") == plain


@pytest.mark.slow
def test_pyplot_is_not_loaded() -> None:
    code = (
        "import sys, report_cases as cases; cases.make_run(rows=9).plot()._repr_svg_();"
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT / "tests" / "support", check=False)
    assert run.returncode == 0


def test_a_run_without_a_sample_has_empty_figures() -> None:
    run: Run = CASES["no row"]()
    assert plots.overview(run).axes[0].lines[0].get_xdata().size == 0


def test_a_broken_cable_is_gone_at_the_end():
    run = make_run()
    gone = replace(run, header=replace(run.header, broken=((1, 0.1),)))
    whole, seven = (markup(sketched(each)).count("stroke-linecap") for each in (run, gone))
    assert seven == whole - 1


@pytest.mark.parametrize(
    ("low", "high", "most", "ticks"),
    [
        (0.0, 4.0, 9, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]),
        (-1.2, 1.2, 6, [-1.0, -0.5, 0.0, 0.5, 1.0]),
        (0.0, 7.0, 6, [0.0, 2.0, 4.0, 6.0]),
        (3.0, 3.0, 6, []),
        (np.nan, 1.0, 6, []),
        (0.0, np.inf, 6, []),
        (5e-324, 1e-323, 6, []),
    ],
)
def test_ticks_are_round_numbers_within(low, high, most, ticks) -> None:
    assert ticks_within(low, high, most) == pytest.approx(ticks)


@example(6.592422886904324e16, 100.0, 3)  # where ticks are rounded to 8
@example(9007199254740991.0, 1.0, 5)  # and to 1
@given(st.floats(-1e300, 1e300), st.floats(1e-12, 1e300), st.integers(2, 12))
def test_ticks_of_any_range_are_few_and_inside(low, width, most) -> None:
    high = low + width
    found = ticks_within(low, high, most)
    assert len(found) <= most + 1
    slack = 1e-8 * (high - low)
    assert all(low - slack <= tick <= high + slack for tick in found)


def test_numbers_share_their_digits_and_a_power_where_they_are_far_from_one() -> None:
    assert numbers([0.0, 0.25, 0.5], range(-4, 5)) == (["0.00", "0.25", "0.50"], "")
    assert numbers([-2e-7, 0.0, 2e-7], range(-4, 5)) == (["−2", "0", "2"], "×10⁻⁷")
    assert numbers([1e6, 1.5e6], range(-4, 5)) == (["1.0", "1.5"], "×10⁶")
    assert numbers([], range(-4, 5)) == ([], "")


def test_a_line_with_gaps_is_drawn_in_pieces_and_without_points_that_change_nothing() -> None:
    sheet = OnPage(2.0, 1.0)
    frame = sheet.frame((0.0, 0.0, 2.0, 1.0))
    frame.scale(x=(0.0, 144.0), y=(72.0, 0.0))
    frame.line([0, 10, 20, 30, np.nan, 40, 50, 60, 70], [0, 10, 20, 0, 0, 5, 5, np.inf, 7], {"color": "#000000"})
    (path,) = re.findall(' d="([^"]*)"', sheet.markup("test"))
    assert path == "M0 0L20 20L30 0M40 5L50 5M70 7h0"
