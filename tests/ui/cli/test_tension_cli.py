"""`cdpr tension`: the table, the figures, the picture, the errors; and that no solver is believed."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT, crossed_box, make_robot
from scipy.optimize import linprog

from cdpr.analysis.distribution.comparison import Contestant, compare, describe
from cdpr.base.errors import CdprError, OutputError, PluginError, ScenarioError
from cdpr.log.run_json import to_json
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.plugins import PluginInfo, PluginOptions, TensionSolver
from cdpr.plugins.registry import Registered, registry
from cdpr.scenario import load_robot
from cdpr.tension import Status
from cdpr.tension.problem import Problem
from cdpr.ui.cli.tension import command
from cdpr.ui.report.figures.placing import spread_out
from cdpr.ui.report.text.distributions import lines, no_picture
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import MinimumNorm

SCENARIOS = ROOT / "scenarios"
PLANAR, CAROCA, POINT = (SCENARIOS / "robots" / f"{name}.yaml" for name in ("planar", "caroca", "point_mass"))


def run(*arguments, code=0):
    result = CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result


def figures(*arguments):
    return json.loads(run(*arguments, "--json").stdout)


def box_problem(m=8, wrench=(0, 0, 200.0, 0, 0, 0), limits=(10.0, 500.0)):
    robot = make_robot(crossed_box(np.random.default_rng(3), m), limits=limits)
    return Problem(robot, np.array([0.1, 0.0, 2.0, 1.0, 0, 0, 0]), np.array(wrench, dtype=float))


def told(problem, solve, *, respects_bounds=True):
    (answer,) = compare(problem, [Contestant("it", lambda: solve, respects_bounds)])
    return answer


def test_default_is_qp_on_the_weight_at_home():
    out = figures(PLANAR)
    assert [a["solver"] for a in out["solvers"]] == ["qp"]
    assert out["pose"]["source"] == "home"
    np.testing.assert_allclose(out["wrench"]["value"], [0, 0, 20 * 9.81, 0, 0, 0], atol=1e-12)
    (answer,) = out["solvers"]
    np.testing.assert_allclose(answer["tension_N"], [157.66, 157.66, 10, 10], atol=0.005)
    assert answer["norm_N"] == pytest.approx(np.linalg.norm(answer["tension_N"]))
    assert (answer["margin_N"], answer["at_limit"], answer["admissible"]) == (0.0, 2, True)
    assert answer["time_us"] > 0.0
    space = out["null_space"]
    t = np.array(space["particular_N"]) + np.array(space["basis"]) @ answer["null_space_N"]
    np.testing.assert_allclose(t, answer["tension_N"], atol=1e-9)


def test_one_option_may_list_several_solvers():
    assert [a["solver"] for a in figures(PLANAR, "--solver", "qp,lp", "--solver", "centroid")["solvers"]] == [
        "qp",
        "lp",
        "centroid",
    ]


def test_pose_wrench_and_changes_are_taken():
    out = figures(PLANAR, "--pose", "0.5,0,1.5,0,0.1,0", "--wrench", "10,0,250,0,5,0", "--set", "tension.max=600")
    assert out["wrench"] == {"source": "--wrench", "value": [10, 0, 250, 0, 5, 0]}
    assert out["pose"]["position_m"] == [0.5, 0, 1.5]
    assert {cable["tension_max_N"] for cable in out["cables"]} == {600.0}
    t = np.array(out["solvers"][0]["tension_N"])
    W = wrench_matrix(load_robot(PLANAR), make_state([0.5, 0, 1.5], out["pose"]["orientation_wxyz"]))
    np.testing.assert_allclose((W @ t)[[0, 2, 4]], [10, 250, 5], atol=1e-9)


class Fixed(TensionSolver):
    """Answers according to its options."""

    def solve(self, W, wrench, t_min, t_max, tension):
        tension[:] = self.options.answer
        return Status.OK


class FixedOptions(PluginOptions):
    answer: float = 1.0


def test_a_scenario_gives_pose_gravity_and_the_options_of_its_solver(monkeypatch):
    info = PluginInfo(name="fixed", factory=f"{__name__}:Fixed", summary="", options=FixedOptions)
    monkeypatch.setitem(registry().plugins["solver"], "fixed", Registered("solver", info, "cdpr", "1"))
    changes = ["world.gravity=[0, 0, -1.62]", "solver.type=fixed", "solver.answer=23.0"]
    chosen = [word for change in changes for word in ("--set", change)]
    out = figures(SCENARIOS / "planar.yaml", *chosen, "--solver", "fixed")
    assert out["pose"] == {"source": "initial", "position_m": [-0.5, 0, 1.2], "orientation_wxyz": [1, 0, 0, 0]}
    assert out["wrench"]["value"][2] == pytest.approx(20 * 1.62)
    (answer,) = out["solvers"]
    assert answer["tension_N"] == [23.0] * 4
    assert not answer["true"]
    assert figures(PLANAR, "--solver", "fixed")["solvers"][0]["tension_N"] == [1.0] * 4


def test_text_of_all_solvers(tmp_path):
    text = run(CAROCA, "--solver", "all", "--out", tmp_path).stdout
    for expected in (
        "caroca at [0, 0, 1.2] m, upright (home)",
        "[0, 0, 1471.5, 0, 0, 0] N, N m (holds the weight)",
        "50 to 10000 N, all cables",
        "6 of n = 6",
        "yes; the best distribution stays 314.637 N from all limits",
        "closed_form",
        "pseudo_inverse",
    ):
        assert expected in text
    names = [row.split()[0] for row in text.splitlines() if row.startswith("  ")]
    assert all(names.count(name) >= 1 for name in registry().names("solver"))
    assert max(map(len, text.splitlines())) <= max(120, len(str(tmp_path / "tension.svg")))


def test_twelve_cables_are_legible():
    problem = box_problem(12)
    rows = list(
        lines(to_json(describe(problem, [told(problem, MinimumNorm(problem.robot, QpOptions()).solve)], "here", "x")))
    )
    assert max(map(len, rows)) <= 120
    heads = [row.split() for row in rows if "tension (N)" in row]
    assert len(heads) == 2
    assert [name for head in heads for name in head[2:]] == [f"cable_{i}" for i in range(1, 13)]


@pytest.mark.parametrize("m", [6, 7, 8, 12])
@pytest.mark.parametrize("load", [50.0, 800.0, 5000.0])
def test_the_largest_margin_is_a_linear_programs(m, load):
    problem = box_problem(m, (load, 0, 200.0, 0, 10.0, 0))
    low, high = problem.limits
    A = np.block([[-np.eye(m), np.ones((m, 1))], [np.eye(m), np.ones((m, 1))]])
    bounds = [(None, None)] * (m + 1)
    best = linprog([0.0] * m + [-1.0], A, np.concatenate([-low, high]), np.hstack([problem.W, np.zeros((6, 1))]),
                   problem.wanted, bounds)  # fmt: skip
    margin, x = problem.safest
    assert margin == pytest.approx(-best.fun, abs=1e-5 * max(1.0, load))
    assert problem.feasible == (best.fun <= 0.0)
    particular, N = problem.general
    t = particular + N @ x
    assert np.minimum(t - low, high - t).min() == pytest.approx(margin, abs=1e-6 * load)


def test_wrong_declarations_are_reported():
    problem = box_problem()
    low, high = problem.limits
    good = np.empty(8)
    assert MinimumNorm(problem.robot, QpOptions()).solve(problem.W, problem.wanted, low, high, good) == 0

    def says(code, answer=None):
        def solve(W, wrench, t_min, t_max, tension):
            if answer is not None:
                tension[:] = answer
            return code

        return solve

    def spoils(W, wrench, t_min, t_max, tension):
        wrench[:] = 0.0
        return 0

    def raises(*_):
        raise RuntimeError("no licence")

    kernel = problem.general[1][:, 0]
    assert told(problem, says(0, good)).admissible
    for answer, reason in [
        (told(problem, says(0, good + 1.0)), "returns OK, but leaves"),
        (told(problem, says(0)), "returns OK, but some tensions are not finite"),
        (told(problem, says(0, good + 900.0 * kernel)), "returns OK, but goes"),
        (
            told(problem, says(1)),
            "reports that no tensions within the limits balance the wrench; but such tensions exist",
        ),
    ]:
        assert not answer.admissible
        assert not answer.true
        assert answer.reason.startswith(reason), answer.reason
    for answer, reason in [
        (told(problem, says(0, good + 900.0 * kernel), respects_bounds=False), "ignores the limits and goes"),
        (told(problem, says(3)), "does not support"),
        (told(problem, says(2)), "found no tensions"),
        (told(problem, says(77)), "returned 77, which is not a status"),
        (told(problem, raises), "raised RuntimeError: no licence"),
        (told(problem, spoils), "raised ValueError"),
    ]:
        assert not answer.admissible
        assert answer.reason.startswith(reason), answer.reason
    rows = list(lines(to_json(describe(problem, [told(problem, says(0)), told(problem, raises)], "here", "x"))))
    assert any("OK, untrue" in row for row in rows)
    assert "  it: raised RuntimeError: no licence" in rows


@pytest.mark.parametrize("absurd", [1e12, 1e200, -1.7e308])
@pytest.mark.usual("1e+200")
def test_absurd_answers_spoil_neither_table_nor_picture(absurd):
    pytest.importorskip("matplotlib")
    from cdpr.ui.report.figures.null_space import draw_null_space

    problem = box_problem()

    def solve(W, wrench, t_min, t_max, tension):
        tension[:] = absurd * problem.general[1][:, 0]
        return 0

    answers = [told(problem, MinimumNorm(problem.robot, QpOptions()).solve), told(problem, solve)]
    out = to_json(describe(problem, answers, "here", "x"))
    assert max(map(len, lines(out))) <= 120
    svg = draw_null_space(out)
    # With and without computable coordinates, it does not change what is shown of the rest.
    assert (">far out of view: it<" in svg) == (out["solvers"][1]["null_space_N"] is not None)
    assert draw_null_space({**out, "solvers": out["solvers"][:1]}).count("<path") == svg.count("<path")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--pose", "1,2"], "--pose: expected three numbers x,y,z"),
        (["--wrench", "1,2"], "--wrench: expected three numbers fx,fy,fz"),
        (["--wrench", "1,2,nan"], "got '1,2,nan'"),
        (["--wrench", "a,b,c"], "expected .*, such as 0,0,500"),
        (["--wrench", "0,5,0,0,0,1"], "the robot moves along x, z, ry only.* give 0 for y, rz"),
    ],
)
def test_bad_arguments_are_one_clear_error(arguments, reason):
    result = run(PLANAR, *arguments, "--json", code=2)
    assert result.stdout == ""
    assert re.search(reason, result.stderr)


def test_errors_of_files_poses_and_solvers():
    with pytest.raises(ScenarioError, match=r"nothing\.yaml"):
        run("nothing.yaml")
    with pytest.raises(CdprError, match="cable 'cable_1' has no length"):
        run(POINT, "--pose", "20,0,12")
    with pytest.raises(PluginError, match="did you mean 'qp'"):
        run(PLANAR, "--solver", "qpp")


def test_a_missing_package_is_an_error_only_where_the_solver_is_named(monkeypatch):
    info = PluginInfo(name="far", factory="x:Y", summary="", requires=("no_such_module",), extra="cdpr[far]")
    monkeypatch.setitem(registry().plugins["solver"], "far", Registered("solver", info, "cdpr", "1"))
    with pytest.raises(PluginError, match=r"needs no_such_module.*pip install 'cdpr\[far\]'"):
        run(PLANAR, "--solver", "far")
    out = figures(PLANAR, "--solver", "all")
    (far,) = [a for a in out["solvers"] if a["solver"] == "far"]
    assert far["status"] is None
    assert far["reason"] == "not installed: pip install 'cdpr[far]'"
    assert any(a["solver"] == "qp" and a["admissible"] for a in out["solvers"])


@pytest.mark.parametrize(
    ("file", "arguments", "expected"),
    [
        (PLANAR, [], [">x (N)<", ">cable_1<", ">t_min 10 N<", ">cable_1 max, cable_2 max<"]),
        (CAROCA, ["--pose", "1.5,1,2.2"], [">x₁ (N)<", ">x₂ (N)<", ">cable_1 min<"]),
        (PLANAR, ["--wrench", "9000,0,0"], [">no tensions are admissible<", ">x (N)<"]),
        (CAROCA, ["--set", "tension.max=300"], [">no tensions are admissible<", ">x₂ (N)<"]),
    ],
)
@pytest.mark.usual("file0-*", "file3-*")
def test_picture_and_figures_are_written(tmp_path, file, arguments, expected):
    pytest.importorskip("matplotlib")
    svgs = []
    for folder in (tmp_path / "a" / "b", tmp_path / "c"):
        text = run(file, *arguments, "--solver", "qp", "--solver", "pseudo_inverse", "--out", folder).stdout
        assert text.splitlines()[-1] == str(folder / "tension.svg")
        svgs.append((folder / "tension.svg").read_bytes())
        out = json.loads((folder / "tension.json").read_text())
        assert [a["solver"] for a in out["solvers"]] == ["qp", "pseudo_inverse"]
    assert svgs[0] == svgs[1]
    ElementTree.fromstring(svgs[0])
    svg = svgs[0].decode()
    for name in ("qp", "pseudo_inverse")[not out["feasible"] :]:
        assert name in svg
    for word in expected:
        assert word in svg, word


def test_a_locked_cable_bounds_nothing_in_the_picture():
    pytest.importorskip("matplotlib")
    from cdpr.ui.report.figures.null_space import draw_null_space

    problem = box_problem()
    t = np.linspace(100.0, 400.0, 8)
    locked = replace(problem.robot.cables[2], tension_min=t[2], tension_max=t[2])
    cables = (*problem.robot.cables[:2], locked, *problem.robot.cables[3:])
    held = Problem(replace(problem.robot, cables=cables), problem.pose, problem.W @ t)
    out = to_json(describe(held, [told(held, MinimumNorm(held.robot, QpOptions()).solve)], "here", "x"))
    assert out["null_space"]["dimension"] == 1
    assert out["solvers"][0]["tension_N"][2] == t[2]
    svg = draw_null_space(out)
    assert "cable_3 min" not in svg
    assert svg.count(">t_min 10 N<") + svg.count(">t_max 500 N<") <= 2


def test_default_output_folders(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    run(PLANAR, "--json")
    assert list(tmp_path.iterdir()) == []
    assert run(PLANAR).stdout.splitlines()[-1] == "runs/tension/planar/tension.svg"
    assert (tmp_path / "runs/tension/planar/tension.json").is_file()
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        run(PLANAR, "--out", "file")


@pytest.mark.parametrize(
    ("problem", "reason"),
    [
        (box_problem(6), "r = 0"),
        (box_problem(5), "no tensions balance the wrench, with any limits"),
    ],
)
def test_why_there_is_no_picture(problem, reason):
    out = to_json(describe(problem, [], "here", "x"))
    assert reason in no_picture(out)
    assert any(row.startswith("  no picture: ") for row in lines(out))


def test_more_than_two_redundant_cables_are_drawn_by_their_ranges(tmp_path):
    pytest.importorskip("matplotlib")
    run(SCENARIOS / "robots" / "twelve.yaml", "--solver", "lp", "--solver", "pseudo_inverse", "--out", tmp_path)
    told = json.loads((tmp_path / "tension.json").read_text())
    words = [
        text.text or "" for text in ElementTree.parse(tmp_path / "tension.svg").iter() if text.tag.endswith("}text")
    ]
    assert {f"cable_{i}" for i in range(1, 13)} <= set(words)
    assert {"lp", "pseudo_inverse (not admissible)"} <= set(words)
    spans = np.array(told["ranges_N"])
    lp = next(a for a in told["solvers"] if a["solver"] == "lp")
    assert (spans[:, 0] - 1e-6 <= lp["tension_N"]).all()
    assert (lp["tension_N"] <= spans[:, 1] + 1e-6).all()
    endless = to_json(describe(box_problem(12, limits=(10.0, np.inf)), [], "here", "x"))
    assert "some limits are infinite" in no_picture(endless)


def test_numbers_are_spread_in_order():
    places = spread_out([1.0, 1.05, 5.0, 1.1, 9.95], 0.5, 0.0, 10.0)
    ordered = [places[i] for i in (0, 1, 3, 2, 4)]
    assert ordered == sorted(ordered)
    assert min(np.diff(ordered)) >= 0.5 - 1e-12
    assert places[2] == 5.0
    assert ordered[0] >= 0.0
    assert ordered[-1] <= 10.0
